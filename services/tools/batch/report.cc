#include "services/tools/batch/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

#include "common/core/joined.h"
#include "common/core/printable.h"
#include "common/core/read_text.h"
#include "common/logfile/log_error.h"
#include "common/messages/codec.h"
#include "common/picture/color_map.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"
#include "services/tools/batch/log_task.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr char kStyle[] = R"(body { max-width: 1500px; }
h3 { font-size: 1em; margin: 1.4em 0 .2em; }
th, td { text-align: right; } th:first-child, td:first-child { text-align: left; white-space: nowrap; }
td.strip { text-align: left; } td.none { color: #bbb; }
.better { color: #176117; } .worse { color: #a31515; }
.b { fill: none; stroke: #c2540a; stroke-width: 1.8; } .both { fill: #a9a49c; }
.strip polygon { fill: #c2540a; } svg.strip { background: #f4f1ee; vertical-align: middle; }
.pictures img { vertical-align: top; margin: 0 8px 4px 0; width: calc(25% - 14px); }
pre { background: #f5f5f3; padding: .5em .8em; overflow-x: auto; font-size: 12.5px; }
details { margin: .2em 0 1em; } summary { cursor: pointer; color: #444; }
.key { display: inline-block; width: 1em; height: .7em; margin: 0 .3em 0 1em; }
)";

// How the variants differ, in some words.
std::string Verdict(const FrameTable& frames) {
  const std::vector<float> changed = frames.Column("changed");
  const auto touched = std::ranges::count_if(changed, [](float x) { return x > 0; });
  const auto compared = std::ranges::count_if(changed, [](float x) { return !std::isnan(x); });
  const int64_t others = std::ssize(changed) - compared;
  if (compared == 0) return "A and B have maps of no frame in common";
  const std::string rest =
      others > 0 ? fmt::format("; {} frames have no two maps to compare", others) : "";
  if (touched == 0) return "A and B give the same maps" + rest;
  return fmt::format("{} frames differ; {:.2f} % of the pixels move by more than 1 px", touched,
                     100 * MeanOf(frames.Column("moved"))) +
         rest;
}

std::string SummaryHtml(const Manifest& manifest, const BatchState& state,
                        const FrameTable& frames) {
  std::string html =
      fmt::format("<h1>{} log{}, {} frames: {}</h1>\n", manifest.log_size(),
                  manifest.log_size() == 1 ? "" : "s", frames.size(),
                  manifest.variant_size() > 1 ? Verdict(frames) : "one configuration");
  for (int i = 0; i < manifest.variant_size(); ++i) {
    std::set<std::string> versions;
    for (const StageProgram& program : manifest.variant(i).program()) {
      versions.insert(program.version());
    }
    html += fmt::format(
        "<div><b>{}</b>: configuration {} (<a href=\"config_{}.textproto\">all of it</a>)",
        i == 0 ? "A" : "B", manifest.variant(i).config_digest(), VariantName(i));
    for (const std::string& version : versions) html += ", " + EscapedHtml(version);
    html += "</div>\n";
  }
  if (state.missing > 0) {
    html += fmt::format(
        "<p class=\"bad\">{} of {} logs are missing: this is a part of the batch.</p>\n",
        state.missing, manifest.log_size());
  }
  return html;
}

std::vector<std::string> LinesOf(const fs::path& path) {
  std::istringstream file(ReadText(path).value_or(""));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::string ConfigChangeHtml(const BatchFolder& folder) {
  std::vector<std::string> a = LinesOf(folder.config(0));
  std::vector<std::string> b = LinesOf(folder.config(1));
  a.resize(std::max(a.size(), b.size()));
  b.resize(a.size());
  std::string text;
  // Both print every field in one order, so lines are counterparts.
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i]) text += "A " + a[i] + "\nB " + b[i] + "\n";
  }
  if (text.empty()) return "<p>The configurations are the same; the programs differ.</p>\n";
  return "<p>The configurations differ in</p>\n<pre>" + EscapedHtml(text) + "</pre>\n";
}

std::string DistributionsHtml(const Manifest& manifest, const FrameTable& frames) {
  const bool has_b = manifest.variant_size() > 1;
  std::string html = "<h2>Distributions over the frames</h2>\n";
  html += "<p><span class=\"key\" style=\"background:#9dbbd8\"></span>A";
  if (has_b) html += "<span class=\"key\" style=\"background:#c2540a;height:.2em\"></span>B";
  html += "</p>\n";
  if (has_b) {
    html += HistogramSvg("share of pixels that move by more than 1 px", frames.Column("moved"), {},
                         "both");
    html += HistogramSvg("mean change, px", frames.Column("mean_change_px"), {}, "both");
  }
  for (const std::string& measure : ShownMeasures(manifest)) {
    html += HistogramSvg(measure, frames.Column("a_" + measure), frames.Column("b_" + measure));
  }
  return html;
}

constexpr size_t kShownFrames = 8;
constexpr int kPictureWidth = 420;  // px; the report has dozens
constexpr int kJpegQuality = 85;

std::string Image(const cv::Mat& picture) {
  cv::Mat small = picture;
  if (picture.cols > kPictureWidth) {
    cv::resize(picture, small, cv::Size(kPictureWidth, picture.rows * kPictureWidth / picture.cols),
               0, 0, cv::INTER_AREA);
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return "<img alt=\"\" src=\"" + DataUrl("image/jpeg", jpeg) + "\">\n";
}

// Grey where both agree, from blue to red (2 px and more) where they differ, white where only one
// has a disparity.
cv::Mat3b DifferencePicture(const DisparityImage& a, const DisparityImage& b) {
  cv::Mat3b picture(a.size());
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const bool in_a = a.IsValid(u, v);
      const bool in_b = b.IsValid(u, v);
      const double px = in_a && in_b ? std::abs(a.Px(u, v) - b.Px(u, v)) : 0;
      picture(v, u) = in_a != in_b ? cv::Vec3b(255, 255, 255)
                      : px == 0    ? cv::Vec3b(64, 64, 64)
                                   : ColorOf(px, {.min = 0, .max = 2});
    }
  }
  return picture;
}

std::string Maps(const std::vector<DisparityImage>& maps, const std::vector<std::string>& names) {
  if (maps.empty()) return "";
  const ValueRange range = DisparityRange(maps, {});
  std::string html;
  for (size_t i = 0; i < maps.size(); ++i) {
    html += Image(DisparityPicture(maps[i], range, names[i]));
  }
  if (maps.size() == 2 && maps[0].size() == maps[1].size()) {
    html += Image(CameraPicture(DifferencePicture(maps[0], maps[1]), "|A - B|"));
  }
  return html;
}

std::string InWords(const std::string& column, double value) {
  if (column == "moved") {
    return fmt::format("{:.2f} % of the pixels move by more than 1 px", 100 * value);
  }
  return fmt::format("score {:.3f}", value);
}

}  // namespace

void WriteReport(const BatchFolder& folder, const Manifest& manifest, const BatchState& state,
                 const FrameTable& frames, const std::string& program) {
  const bool has_b = manifest.variant_size() > 1;
  std::string html = PageStart("sprout-batch", kStyle) + SummaryHtml(manifest, state, frames) +
                     MeansHtml(manifest, frames);
  if (has_b) html += ConfigChangeHtml(folder);
  html += LossesHtml(folder, manifest, state) + DistributionsHtml(manifest, frames) +
          LogsHtml(manifest, frames);
  ReportFrames shown(folder, manifest, frames, fs::path(program).parent_path());
  if (has_b) html += shown.Html("The most changed frames", "moved", /*lowest=*/false);
  html += shown.Html("The worst frames", has_b ? "b_score" : "a_score", /*lowest=*/true);
  html +=
      "<h2>Files</h2>\n<p><a href=\"frames.csv\">frames.csv</a>: a row a frame, with all figures. "
      "logs/NAME_a.lcm, NAME_b.lcm: the answers. manifest.textproto: logs, programs, "
      "digests.</p>\n";
  WriteText(folder.report(), html + PageEnd());
}

std::string FrameCommands(const BatchFolder& folder, const Manifest& manifest, const BatchLog& log,
                          int64_t seq, const std::filesystem::path& programs) {
  const auto line = [&](std::vector<std::string> words) {
    const std::string& prefix = manifest.channel_prefix();
    if (!prefix.empty()) words.push_back("--channel-prefix=" + prefix);  // may begin with -
    return Joined(" ", words, ShellWord) + "\n";
  };
  const std::string frame = std::to_string(seq);
  std::string text =
      line({(programs / "sprout-view").string(), "--log", log.path(), "--frame", frame});
  for (int i = 0; i < manifest.variant_size(); ++i) {
    std::vector<std::string> replays = {"--replay", log.path()};
    for (int s = 0; s < manifest.stage_size(); ++s) {
      const std::string record = fmt::format("{}_{}.lcm", manifest.stage(s), VariantName(i));
      std::vector<std::string> words = {manifest.variant(i).program(s).path(), "--config",
                                        folder.config(i).string(), "--frames", frame};
      words.insert(words.end(), replays.begin(), replays.end());
      words.insert(words.end(), {"--record", record});
      text += line(std::move(words));
      replays.insert(replays.end(), {"--replay", record});
    }
  }
  return text;
}

std::string ReportFrames::Html(const std::string& title, const std::string& column, bool lowest) {
  const std::vector<float> values = frames_.Column(column);
  std::vector<size_t> order;
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i]) && (lowest || values[i] > 0)) order.push_back(i);
  }
  std::ranges::stable_sort(order, [&](size_t x, size_t y) {
    return lowest ? values[x] < values[y] : values[x] > values[y];
  });
  order.resize(std::min(kShownFrames, order.size()));
  if (order.empty()) return "";
  std::string html = "<h2>" + title + "</h2>\n";
  if (manifest_.variant_size() > 1) {
    html +=
        "<p>|A - B|: grey where they agree, blue to red up to 2 px and more, white where only one "
        "has a disparity.</p>\n";
  }
  for (const size_t row : order) {
    html += fmt::format("<h3>{}, frame {}: {}</h3>\n",
                        EscapedHtml(manifest_.log(frames_.LogOf(row)).name()), frames_.SeqOf(row),
                        InWords(column, values[row]));
    html += OneHtml(row);
  }
  return html;
}

std::string ReportFrames::OneHtml(size_t row) {
  const std::string commands = FrameCommands(folder_, manifest_, manifest_.log(frames_.LogOf(row)),
                                             frames_.SeqOf(row), programs_);
  const std::string more = "<details><summary>look at it, compute it again</summary><pre>" +
                           EscapedHtml(commands) + "</pre></details>\n";
  try {
    return "<div class=\"pictures\">" + PicturesHtml(row) + "</div>\n" + more;
  } catch (const LogError& e) {
    return "<p class=\"bad\">No pictures: " + EscapedHtml(e.what()) + "</p>\n" + more;
  }
}

// Left image, the map of each variant on one scale, and where they differ, side by side.
std::string ReportFrames::PicturesHtml(size_t row) {
  std::string html;
  if (const cv::Mat left = LeftOf(row); !left.empty()) {
    html += Image(CameraPicture(left, "Left image"));
  }
  const auto utime = static_cast<int64_t>(*frames_.table().rows[row][1]);
  const FrameId id{.utime = utime, .seq = frames_.SeqOf(row), .rig_id = {}};
  std::vector<DisparityImage> maps;
  std::vector<std::string> names;
  for (int i = 0; i < manifest_.variant_size(); ++i) {
    Frame frame =
        AnswersOf(frames_.LogOf(row), i).Get(id, {Part::kFused, Part::kDisparity, Part::kPrior});
    if (frame.fused) frame.disparity = frame.fused;
    if (!frame.disparity && frame.prior) frame.disparity = frame.prior->disparity;
    if (!frame.disparity || frame.disparity->empty()) continue;
    maps.push_back(*frame.disparity);
    names.emplace_back(i == 0 ? "A: disparity" : "B: disparity");
  }
  return html + Maps(maps, names);
}

FrameLookup& ReportFrames::AnswersOf(int log, int variant) {
  auto& lookup = answers_[{log, variant}];
  if (!lookup) {
    lookup = std::make_unique<FrameLookup>(manifest_.channel_prefix());
    lookup->Add(folder_.result(manifest_, log, variant) / kAnswers);
  }
  return *lookup;
}

cv::Mat ReportFrames::LeftOf(size_t row) const {
  const Cell place = frames_.table().rows[row][2];
  if (!place) return {};
  EventFetcher log(manifest_.log(frames_.LogOf(row)).path());
  const Result<DecodedPart> left =
      DecodePart(Part::kLeft, log.Fetch(static_cast<int64_t>(*place)).data);
  return left ? std::get<cv::Mat>(left->value) : cv::Mat();
}

}  // namespace sprout::batch
