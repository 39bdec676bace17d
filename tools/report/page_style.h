// The style sheet of report.html.
#pragma once

namespace bakelight::report {

const char* pageStyle();

}  // namespace bakelight::report
