// report.html: one self-contained page, without scripts and without anything from elsewhere.
#pragma once

#include <string>

#include "tools/report/evaluation.h"
#include "tools/report/plan.h"
#include "tools/report/thumbnails.h"

namespace bakelight::report {

std::string pageHtml(const Plan& plan, const Evaluation& evaluation, const Thumbnails& thumbnails);

}  // namespace bakelight::report
