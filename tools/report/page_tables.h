// The tables of report.html, each with its heading; empty where there is nothing to tell.
#pragma once

#include <string>

#include "tools/report/evaluation.h"
#include "tools/report/plan.h"
#include "tools/report/varied.h"

namespace bakelight::report {

std::string causesTable(const Plan& plan, const Evaluation& evaluation);
// Windows that were chosen by the error that they save.
std::string windowsTable(const Plan& plan, const Evaluation& evaluation);
std::string variantsTable(const Plan& plan, const Evaluation& evaluation);
// Ways to store a transfer matrix in a pixel basis.
std::string storageTable(const Plan& plan, const Evaluation& evaluation);
std::string leftOutTable(const Plan& plan, const Evaluation& evaluation, const Varied& varied);
std::string stagesTable(const Plan& plan, const Varied& varied);
std::string failedTable(const Plan& plan);
// How each figure is defined, and the noise of the references.
std::string definitions(const Plan& plan, const Evaluation& evaluation);

}  // namespace bakelight::report
