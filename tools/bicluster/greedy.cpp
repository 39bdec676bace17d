#include "tools/bicluster/greedy.h"

#include <algorithm>
#include <bit>
#include <queue>
#include <random>
#include <stdexcept>

namespace bakelight::bicluster {
namespace {

struct Element {
  std::uint32_t at;  // column of a row's element, row of a column's
  std::int16_t value;
};

// Both the rows and the columns of what is left of the matrix.
class Remainder {
 public:
  explicit Remainder(const formats::PixelCodes& codes)
      : rows_(codes.rowCount()), columns_(codes.columnCount()), tree_(codes.rowCount() + 1, 0) {
    for (std::uint32_t row = 0; row < rows_.size(); ++row) {
      for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i) {
        rows_[row].push_back({codes.columns[i], codes.codes[i]});
        columns_[codes.columns[i]].push_back({row, codes.codes[i]});
      }
      add(row, static_cast<std::int64_t>(rows_[row].size()));
    }
  }

  const std::vector<Element>& row(std::uint32_t i) const { return rows_[i]; }
  const std::vector<Element>& column(std::uint32_t i) const { return columns_[i]; }
  std::size_t rowCount() const { return rows_.size(); }
  std::size_t columnCount() const { return columns_.size(); }
  std::uint64_t elements() const { return elements_; }

  // Row and place in it of the element that has so many before it.
  std::pair<std::uint32_t, std::uint32_t> elementAt(std::uint64_t index) const {
    std::size_t row = 0;
    for (std::size_t step = std::bit_floor(rows_.size()); step > 0; step /= 2)
      if (row + step < tree_.size() && tree_[row + step] <= index) index -= tree_[row += step];
    return {static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(index)};
  }

  void subtract(const Bicluster& cluster) {
    subtractFrom(columns_, cluster.columns, cluster.rows,
                 [&](std::size_t c, std::size_t) { return cluster.values[c]; });
    std::vector<std::uint64_t> before;
    for (const std::uint32_t row : cluster.rows) before.push_back(rows_[row].size());
    subtractFrom(rows_, cluster.rows, cluster.columns,
                 [&](std::size_t, std::size_t c) { return cluster.values[c]; });
    for (std::size_t r = 0; r < cluster.rows.size(); ++r)
      add(cluster.rows[r],
          static_cast<std::int64_t>(rows_[cluster.rows[r]].size()) - static_cast<std::int64_t>(before[r]));
  }

 private:
  void add(std::size_t row, std::int64_t count) {
    elements_ += count;
    for (std::size_t i = row + 1; i < tree_.size(); i += i & (~i + 1)) tree_[i] += count;
  }

  // `crossing` must be ascending.
  template <class Lists, class Indices, class Crossing, class Value>
  static void subtractFrom(Lists& lists, const Indices& indices, const Crossing& crossing,
                           const Value& value) {
    std::vector<Element> merged;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      auto& list = lists[indices[i]];
      merged.clear();
      std::size_t c = 0;
      for (const Element& element : list) {
        for (; c < crossing.size() && crossing[c] < element.at; ++c)
          merged.push_back({crossing[c], static_cast<std::int16_t>(-value(i, c))});
        if (c < crossing.size() && crossing[c] == element.at) {
          const auto left = static_cast<std::int16_t>(element.value - value(i, c++));
          if (left != 0) merged.push_back({element.at, left});
        } else {
          merged.push_back(element);
        }
      }
      for (; c < crossing.size(); ++c)
        merged.push_back({crossing[c], static_cast<std::int16_t>(-value(i, c))});
      list.assign(merged.begin(), merged.end());
    }
  }

  std::vector<std::vector<Element>> rows_, columns_;
  std::vector<std::uint64_t> tree_;  // Fenwick's, of the rows' lengths
  std::uint64_t elements_ = 0;
};

// Rows or columns by their score. The front is the best one in the state that is asked for; entries that are out of date are dropped when
// they get there.
class OperationQueue {
 public:
  struct Front {
    bool valid = false;
    std::uint32_t index = 0;
    int score = 0;
  };
  // `sign` 1: greatest score first, −1: least.
  explicit OperationQueue(int sign) : sign_(sign) {}
  void clear() { heap_ = {}; }
  void push(int score, std::uint32_t index) { heap_.push({sign_ * score, ~index}); }
  template <class Current>
  Front front(const Current& current) {
    while (!heap_.empty()) {
      const auto [score, index] = heap_.top();
      if (current(~index, sign_ * score)) return {true, ~index, sign_ * score};
      heap_.pop();
    }
    return {};
  }

 private:
  int sign_;
  std::priority_queue<std::pair<int, std::uint32_t>> heap_;
};

// One bicluster as it grows and shrinks. A row's score is 2 · (elements that have their column's value) + 2 · (elements that are not
// zero), over the columns inside; the influence on the change of cost (equation 9) of its insertion is score − 2l − 1, that of
// its deletion the opposite. A column's score is alike, over the rows inside, with the commonest value as its value while it is
// outside; its influence is score − 2r − 2. So an operation changes the scores only of what crosses it in an element.
class Search {
 public:
  explicit Search(const Remainder& left)
      : left_(left), rows_(left.rowCount()), columns_(left.columnCount()), counts_(left.columnCount()) {}

  Bicluster grow(std::uint32_t row, std::uint32_t element) {
    begin();
    const Element first = left_.row(row)[element];
    columns_[first.at].value = first.value;
    toggleColumn(first.at);
    toggleRow(row);
    for (;;) {
      const Operation best = bestOperation();
      if (best.influence <= 0) break;
      best.is_row ? toggleRow(best.index) : toggleColumn(best.index);
    }
    return result();
  }

 private:
  struct Line {
    int score = 0;
    std::int16_t value = 0;  // a column's
    bool inside = false, touched = false;
  };
  struct ValueCount {
    std::int16_t value;
    int count;
  };
  struct Operation {
    bool is_row = false;
    std::uint32_t index = 0;
    int influence = 0;
  };

  void begin() {
    for (const std::uint32_t row : touched_rows_) rows_[row] = {};
    for (const std::uint32_t column : touched_columns_) columns_[column] = {}, counts_[column].clear();
    touched_rows_.clear(), touched_columns_.clear();
    for (OperationQueue* queue : {&row_insertions_, &row_deletions_, &column_insertions_, &column_deletions_})
      queue->clear();
    row_count_ = column_count_ = 0;
  }

  Operation bestOperation() {
    Operation best;
    const auto consider = [&](const OperationQueue::Front& front, bool is_row, int influence) {
      if (front.valid && influence > best.influence) best = {is_row, front.index, influence};
    };
    const auto is = [](const std::vector<Line>& lines, bool inside) {
      return [&lines, inside](std::uint32_t i, int score) {
        return lines[i].inside == inside && lines[i].score == score;
      };
    };
    OperationQueue::Front front = row_insertions_.front(is(rows_, false));
    consider(front, true, front.score - 2 * column_count_ - 1);
    front = column_insertions_.front(is(columns_, false));
    consider(front, false, front.score - 2 * row_count_ - 2);
    front = row_deletions_.front(is(rows_, true));
    if (row_count_ > 1) consider(front, true, 2 * column_count_ + 1 - front.score);
    front = column_deletions_.front(is(columns_, true));
    if (column_count_ > 1) consider(front, false, 2 * row_count_ + 2 - front.score);
    return best;
  }

  void queueRow(std::uint32_t row) {
    (rows_[row].inside ? row_deletions_ : row_insertions_).push(rows_[row].score, row);
  }
  void queueColumn(std::uint32_t column) {
    (columns_[column].inside ? column_deletions_ : column_insertions_).push(columns_[column].score, column);
  }

  void toggleRow(std::uint32_t row) {
    touch(rows_, touched_rows_, row);
    rows_[row].inside = !rows_[row].inside;
    const int change = rows_[row].inside ? 1 : -1;
    row_count_ += change;
    for (const Element& element : left_.row(row)) {
      touch(columns_, touched_columns_, element.at);
      changeCount(element.at, element.value, change);
      scoreColumn(element.at);
      queueColumn(element.at);
    }
    queueRow(row);
  }

  void toggleColumn(std::uint32_t column) {
    touch(columns_, touched_columns_, column);
    Line& line = columns_[column];
    line.inside = !line.inside;
    const int change = line.inside ? 1 : -1;
    column_count_ += change;
    for (const Element& element : left_.column(column)) {
      touch(rows_, touched_rows_, element.at);
      rows_[element.at].score += change * (element.value == line.value ? 4 : 2);
      queueRow(element.at);
    }
    scoreColumn(column);
    queueColumn(column);
  }

  void changeCount(std::uint32_t column, std::int16_t value, int change) {
    auto& counts = counts_[column];
    const auto at =
        std::find_if(counts.begin(), counts.end(), [&](const ValueCount& c) { return c.value == value; });
    if (at == counts.end()) {
      counts.push_back({value, change});
    } else {
      at->count += change;
    }
  }

  void scoreColumn(std::uint32_t column) {
    Line& line = columns_[column];
    int all = 0, equal = 0;
    for (const ValueCount& c : counts_[column]) {
      all += c.count;
      if (line.inside) {
        if (c.value == line.value) equal = c.count;
      } else if (c.count > equal) {
        equal = c.count, line.value = c.value;
      }
    }
    line.score = 2 * equal + 2 * all;
  }

  static void touch(std::vector<Line>& lines, std::vector<std::uint32_t>& touched, std::uint32_t i) {
    if (lines[i].touched) return;
    lines[i].touched = true;
    touched.push_back(i);
  }

  Bicluster result() const {
    Bicluster cluster;
    for (const std::uint32_t row : touched_rows_)
      if (rows_[row].inside) cluster.rows.push_back(row);
    std::sort(cluster.rows.begin(), cluster.rows.end());
    for (const std::uint32_t column : touched_columns_)
      if (columns_[column].inside) cluster.columns.push_back(static_cast<std::uint16_t>(column));
    std::sort(cluster.columns.begin(), cluster.columns.end());
    for (const std::uint16_t column : cluster.columns) cluster.values.push_back(columns_[column].value);
    return cluster;
  }

  const Remainder& left_;
  std::vector<Line> rows_, columns_;
  std::vector<std::vector<ValueCount>> counts_;
  std::vector<std::uint32_t> touched_rows_, touched_columns_;
  OperationQueue row_insertions_{1}, row_deletions_{-1}, column_insertions_{1}, column_deletions_{-1};
  int row_count_ = 0, column_count_ = 0;
};

}  // namespace

std::uint64_t Biclusters::operations() const {
  std::uint64_t sum = 0;
  for (const Bicluster& cluster : clusters) sum += cluster.rows.size() + 2 * cluster.columns.size() - 1;
  return sum;
}

std::uint64_t Biclusters::bytes() const {
  std::uint64_t sum = 0;
  for (const Bicluster& cluster : clusters) sum += 6 + 4 * cluster.rows.size() + 3 * cluster.columns.size();
  return sum;
}

Biclusters greedyBiclusters(const formats::PixelCodes& codes, std::uint64_t seed) {
  Biclusters biclusters{codes.cube_side, codes.local_side, codes.subsamples, codes.rowCount(), {}};
  Remainder left(codes);
  Search search(left);
  std::mt19937_64 random(seed);
  while (left.elements() > 0) {
    const std::uint64_t before = left.elements();
    const auto [row, element] = left.elementAt(random() % before);
    biclusters.clusters.push_back(search.grow(row, element));
    left.subtract(biclusters.clusters.back());
    if (left.elements() >= before) throw std::logic_error("a bicluster took no element out of the matrix");
  }
  return biclusters;
}

formats::PixelRows decode(const Biclusters& biclusters) {
  std::vector<std::vector<Element>> rows(biclusters.row_count);
  for (const Bicluster& cluster : biclusters.clusters)
    for (const std::uint32_t row : cluster.rows)
      for (std::size_t c = 0; c < cluster.columns.size(); ++c)
        rows[row].push_back({cluster.columns[c], cluster.values[c]});
  formats::PixelRows decoded;
  decoded.cube_side = biclusters.cube_side, decoded.local_side = biclusters.local_side;
  decoded.subsamples = biclusters.subsamples;
  for (auto& row : rows) {
    std::sort(row.begin(), row.end(), [](const Element& a, const Element& b) { return a.at < b.at; });
    for (std::size_t i = 0; i < row.size();) {
      int sum = 0;
      const std::uint32_t column = row[i].at;
      for (; i < row.size() && row[i].at == column; ++i) sum += row[i].value;
      if (sum < 0 || sum > biclusters.subsamples * biclusters.subsamples)
        throw std::logic_error("biclusters do not add up to a code");
      if (sum == 0) continue;
      decoded.columns.push_back(static_cast<std::uint16_t>(column));
      decoded.codes.push_back(static_cast<std::uint8_t>(sum));
    }
    decoded.row_offsets.push_back(decoded.columns.size());
  }
  return decoded;
}

void multiply(const Biclusters& biclusters, std::span<const transport::Radiance4> light,
              std::span<transport::Radiance4> values) {
  const float scale = 1.0F / static_cast<float>(biclusters.subsamples * biclusters.subsamples);
  std::fill(values.begin(), values.end(), transport::Radiance4::Zero());
  for (const Bicluster& cluster : biclusters.clusters) {
    transport::Radiance4 sum = transport::Radiance4::Zero();
    for (std::size_t c = 0; c < cluster.columns.size(); ++c)
      sum += light[cluster.columns[c]] * static_cast<float>(cluster.values[c]);
    sum *= scale;
    for (const std::uint32_t row : cluster.rows) values[row] += sum;
  }
}

}  // namespace bakelight::bicluster
