// report.html in a browser: Chromium, without a display.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "formats/file.h"
#include "formats/json.h"
#include "tests/e2e/made_packs.h"
#include "tests/unit/report/made_report.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

// Looks into each frame and writes down what is laid out how.
constexpr const char* kMeasure = R"js(<pre id="told"></pre><script>
const measure = (document) => {
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const box = e => e.getBoundingClientRect();
  const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 &&
                            Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0.5;
  const width = document.documentElement.clientWidth;
  const plots = all("svg.plot").map(svg => {
    const texts = all("text", svg), collisions = [];
    texts.forEach((a, i) => texts.slice(i + 1).forEach(b => {
      if (overlap(box(a), box(b))) collisions.push(a.textContent + " | " + b.textContent);
    }));
    all("text.label", svg).forEach(label => all(".filled, .hollow", svg).forEach(marker => {
      if (overlap(box(label), box(marker))) collisions.push(label.textContent + " | " + marker.parentNode.dataset.variant);
    }));
    const outside = texts.filter(t => box(t).left < box(svg).left - 0.5 || box(t).right > box(svg).right + 0.5 ||
                                      box(t).bottom > box(svg).bottom + 0.5).map(t => t.textContent);
    return {variants: all(".point", svg).map(p => p.dataset.variant), labels: all("text.label", svg).length,
            front: all(".on-front", svg).length, ticks: all("text.tick", svg).length, collisions, outside};
  });
  return {
    width, scrollWidth: document.documentElement.scrollWidth,
    wide: all("body *").filter(e => !e.closest(".scroll") && !e.closest("svg") && box(e).right > width + 0.5)
                       .map(e => e.tagName + "." + e.className),
    cramped: all(".card, figcaption, h1, h2, h3, p, dd, li").filter(e => e.scrollWidth > e.clientWidth + 1)
                       .map(e => e.textContent),
    images: all("img").map(i => [i.naturalWidth, i.naturalHeight, Math.round(box(i).width)]),
    tables: all(".scroll").length, plots};
};
addEventListener("load", () => {
  const told = {};
  for (const frame of document.querySelectorAll("iframe")) told[frame.clientWidth] = measure(frame.contentDocument);
  document.getElementById("told").textContent = "BEGIN" + JSON.stringify(told) + "END";
});
</script>)js";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

// The page as wide as a phone and as a desktop: a window of Chromium's is no narrower than 500 px.
std::string framesOf(const std::string& page) {
  const std::string content = replaced(replaced(page, "&", "&amp;"), "\"", "&quot;");
  std::string html = "<!DOCTYPE html><meta charset=\"utf-8\"><body>";
  for (const char* width : {"360", "1200"})
    html += std::string("<iframe style=\"border:0;height:800px;width:") + width + "px\" srcdoc=\"" + content +
            "\"></iframe>";
  return html + kMeasure;
}

class ReportPage : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() /
        ("bakelight-page-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    const fs::path plan = makePlan();
    run("'" BAKELIGHT_BIN_DIR "/report' '" + plan.string() + "' --rounds 3 --report '" +
        (folder_ / "report.json").string() + "' --page '" + (folder_ / "report.html").string() + "'");
    page_ = formats::readTextFile(folder_ / "report.html");
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(folder_);
  }

  fs::path makePlan() {
    MadeReport made(madeGlossyPack(7, 16), {.width_px = 200, .height_px = 150, .noise = 0.003});
    formats::Pack truth_mesh = madeGlossyPack(7, 16);
    const Json same = made.addReferences("same mesh", truth_mesh);
    for (const int order : {2, 3, 4, 5, 6})
      for (const auto precision :
           {formats::Precision::kFloat32, formats::Precision::kFloat16, formats::Precision::kUint8}) {
        const std::string text = nameOf(precision);
        formats::Pack pack = madeGlossyPack(order, 16);
        const Json chain = {
            {{"cause", "simplification"}, {"references", same}},
            {{"cause", "sh_truncation"}, {"pack", made.addPack("order" + std::to_string(order), pack)}},
            {{"cause", "storage"}, {"pack", nullptr}}};
        encodeAt(precision, pack);
        Json& variant = made.addVariant("transfer.order=" + std::to_string(order) + " pack.precision=" + text,
                                        {{"transfer.order", order}, {"pack.precision", text}}, pack, chain);
        variant["chain"][2]["pack"] = variant["pack"];
        variant["player"] = {
            {"light_change_ms", 0.3 * order}, {"frame_ms", 10 + order}, {"gpu_frame_ms", 8 + order}};
        variant["left_out"] = {{{"stage", "transfer"},
                                {"what", "bounces between parts that hardly see each other"},
                                {"figure", "survey.bounce_energy"},
                                {"value", 0.0012},
                                {"threshold", 0.005},
                                {"error", 0.0012}}};
        names_.push_back(variant["name"]);
      }
    made.json["failed"].push_back(
        {{"name", "transfer.order=6 <script>alert(1)</script>"},
         {"stage", "transfer"},
         {"reason", "the matrices would take 4.2 GB. Expected: at most 4 GB. Try: a lower order"}});
    return made.write(folder_);
  }

  static void run(const std::string& command) {
    ASSERT_EQ(std::system((command + " 2> /dev/null").c_str()), 0) << command;
  }

  void chromium(const std::string& options, const std::string& file,
                const std::string& redirection = "") const {
    ASSERT_EQ(std::system("command -v chromium > /dev/null"), 0)
        << "install it: scripts/system-packages browser";
    run("HOME='" + folder_.string() +
        "' chromium --headless=new --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir='" +
        (folder_ / "profile").string() + "' " + options + " 'file://" + (folder_ / file).string() + "' " +
        redirection);
  }

  fs::path folder_;
  std::string page_;
  std::vector<std::string> names_;
};

TEST_F(ReportPage, StandsAlone) {
  ASSERT_GT(page_.size(), 20000u);
  for (const char* from_elsewhere :
       {"http:", "https:", "<script", "<link", "<iframe", "@import", "url(", "file:"})
    EXPECT_EQ(page_.find(from_elsewhere), std::string::npos) << from_elsewhere;
  const std::regex source("src=\"([^\"]{0,22})");
  std::size_t images = 0;
  for (auto match = std::sregex_iterator(page_.begin(), page_.end(), source); match != std::sregex_iterator();
       ++match, ++images)
    EXPECT_EQ((*match)[1], "data:image/png;base64,");
  EXPECT_GE(images, 2u * 5);
  EXPECT_NE(page_.find("&lt;script&gt;alert(1)"), std::string::npos) << "text is escaped";
  EXPECT_EQ(page_.find(folder_.string()), std::string::npos) << "paths of this machine";
}

TEST_F(ReportPage, FitsPhonesAndDesktops) {
  formats::writeFileAtomically(folder_ / "frames.html", framesOf(page_));
  chromium("--window-size=1400,900 --dump-dom", "frames.html", "> '" + (folder_ / "dom").string() + "'");
  const std::string dom = formats::readTextFile(folder_ / "dom");
  const std::size_t begin = dom.find("BEGIN{\""), end = dom.find("}END");
  ASSERT_NE(end, std::string::npos);
  const std::string text = dom.substr(begin + 5, end + 1 - begin - 5);
  const Json told = formats::parseJson(
      replaced(replaced(replaced(text, "&lt;", "<"), "&gt;", ">"), "&amp;", "&"), "what Chromium measured");
  ASSERT_EQ(told.size(), 2u);
  for (const char* width : {"360", "1200"}) {
    SCOPED_TRACE(width);
    const Json& page = told.at(width);
    EXPECT_EQ(page["scrollWidth"], page["width"]) << "scrolls sideways: " << page["wide"];
    EXPECT_EQ(page["wide"], Json::array());
    EXPECT_EQ(page["cramped"], Json::array());
    ASSERT_EQ(page["plots"].size(), 3u);
    for (const Json& plot : page["plots"]) {
      EXPECT_EQ(plot["collisions"], Json::array());
      EXPECT_EQ(plot["outside"], Json::array());
      EXPECT_GE(plot["ticks"], 5);
      EXPECT_GE(plot["front"], 1);
      EXPECT_EQ(plot["labels"], plot["front"]) << "every point of the front has its label";
      std::vector<std::string> shown = plot["variants"];
      EXPECT_THAT(shown, testing::UnorderedElementsAreArray(names_));
    }
    ASSERT_GE(page["images"].size(), 10u);
    for (const Json& image : page["images"]) {
      EXPECT_EQ(image[0], 200) << "an image is not decoded";
      EXPECT_EQ(image[1], 150);
      EXPECT_GE(image[2], 100) << "shown too small";
    }
    EXPECT_EQ(page["tables"], 6) << "causes, variants, left out, stages, failed, noise";
  }
}

TEST_F(ReportPage, Prints) {
  chromium("--no-pdf-header-footer --print-to-pdf='" + (folder_ / "page.pdf").string() + "'", "report.html");
  const std::string pdf = formats::readTextFile(folder_ / "page.pdf");
  EXPECT_TRUE(pdf.starts_with("%PDF"));
  const std::regex page_object("/Type ?/Page[^s]");
  const auto pages =
      std::distance(std::sregex_iterator(pdf.begin(), pdf.end(), page_object), std::sregex_iterator());
  EXPECT_GE(pages, 2);
  EXPECT_LE(pages, 8);
}

}  // namespace
}  // namespace bakelight::tests
