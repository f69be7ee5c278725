#include "services/tools/calibrate/report_page.h"

#include <fmt/core.h>

#include "common/picture/html.h"

namespace sprout::calibrate {
namespace {

constexpr char kHead[] = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Calibration of the rig</title>
<style>
body { font: 15px/1.45 sans-serif; max-width: 1440px; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { border-bottom: 1px solid #ccc; padding: .25em .9em .25em 0; text-align: left; }
figure { display: inline-block; margin: .5em 1em .5em 0; vertical-align: top; }
img { max-width: 100%; border: 1px solid #ccc; }
.good { color: #176117; } .bad { color: #a31515; }
</style></head><body>
)";

}  // namespace

std::string VerdictText(bool is_good) { return is_good ? "good" : "not good enough"; }

std::string ReportStart(std::string_view what, const std::vector<std::string>& reasons) {
  std::string html = kHead;
  html += fmt::format("<h1>{}: <span class=\"{}\">{}</span></h1>\n", what,
                      reasons.empty() ? "good" : "bad", VerdictText(reasons.empty()));
  if (reasons.empty()) return html;
  html += "<ul>\n";
  for (const std::string& reason : reasons) html += "<li>" + EscapedHtml(reason) + "</li>\n";
  return html + "</ul>\n";
}

std::string ReportEnd() { return "</body></html>\n"; }

}  // namespace sprout::calibrate
