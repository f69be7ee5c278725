#include "services/tools/calibrate/report_page.h"

#include <fmt/core.h>

#include "common/picture/html.h"

namespace sprout::calibrate {

std::string VerdictText(bool is_good) { return is_good ? "good" : "not good enough"; }

std::string ReportStart(std::string_view what, const std::vector<std::string>& reasons) {
  std::string html = PageStart("Calibration of the rig");
  html += fmt::format("<h1>{}: <span class=\"{}\">{}</span></h1>\n", what,
                      reasons.empty() ? "good" : "bad", VerdictText(reasons.empty()));
  if (reasons.empty()) return html;
  html += "<ul>\n";
  for (const std::string& reason : reasons) html += "<li>" + EscapedHtml(reason) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace sprout::calibrate
