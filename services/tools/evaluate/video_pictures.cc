#include "services/tools/evaluate/video_pictures.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/core/image.h"
#include "common/core/output_file.h"
#include "common/measure/score.h"
#include "common/picture/chart.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"

namespace sprout::evaluate {
namespace {

constexpr int kStripRows = 6;
constexpr std::array<const char*, 3> kLineColors = {"#888888", "#3070c0", "#c03020"};

std::string FileName(std::string source) {
  std::ranges::replace_if(
      source, [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '-'; }, '_');
  return source;
}

double BadPercent(const cv::Mat1f& map, const cv::Mat1f& truth, const cv::Mat1b& mask) {
  int64_t bad = 0, pixels = 0;
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (mask(v, u) == 0 || !std::isfinite(truth(v, u))) continue;
      ++pixels;
      bad += std::abs(map(v, u) - truth(v, u)) <= 3 ? 0 : 1;
    }
  }
  return pixels == 0 ? std::nan("")
                     : 100.0 * static_cast<double>(bad) / static_cast<double>(pixels);
}

// A line for each map, over the numbers of the frames.
LinePlot PlotOf(const std::string& title, const std::array<std::vector<double>, 3>& lines) {
  LinePlot plot = {.title = title,
                   .along = "frame",
                   .up = "bad 3, %",
                   .right = static_cast<double>(std::max<size_t>(2, lines[0].size()) - 1),
                   .top = 0,
                   .lines = {},
                   .size = {480, 200}};
  for (size_t i = 0; i < lines.size(); ++i) {
    LinePlot::Line line = {.points = {}, .color = kLineColors[i], .name = kVideoMapNames[i]};
    for (size_t k = 0; k < lines[i].size(); ++k) {
      line.points.emplace_back(static_cast<double>(k), lines[i][k]);
      plot.top = std::max(plot.top, lines[i][k]);  // not for NaN
    }
    plot.lines.push_back(std::move(line));
  }
  if (plot.top == 0) plot.top = 1;
  return plot;
}

}  // namespace

VideoPictures::VideoPictures(const std::string& source, int frames)
    : source_(source), every_(std::max(1, (frames + kStripRows - 1) / kStripRows)) {}

void VideoPictures::Add(int frame, const cv::Mat& left, const cv::Mat1f& truth,
                        const cv::Mat1b& mask, const VideoMaps& maps) {
  FigureRow row{.cells = {{FigureThumbnail(ToBgr(left)), fmt::format("frame {}", frame)}},
                .scale = {.axes = {{{0, kLargestErrorPx}, "px"}}, .above = true}};
  for (size_t i = 0; i < maps.size(); ++i) {
    const double bad = BadPercent(maps[i], truth, mask);
    bad3_percent_[i].push_back(bad);
    if (frame % every_ != 0) continue;
    row.cells.push_back({FigureThumbnail(ColorizeErrors(ErrorMap(maps[i], truth, mask))),
                         std::isnan(bad) ? "" : fmt::format("bad 3: {:.2f} %", bad)});
  }
  if (frame % every_ == 0) rows_.push_back(std::move(row));
}

void VideoPictures::Write(const std::filesystem::path& folder) const {
  const auto check = [](const Result<void>& written) {
    if (!written) throw std::runtime_error(written.error().text);
  };
  const std::string name = FileName(source_);
  std::vector<std::string> titles = {"left image"};
  titles.insert(titles.end(), kVideoMapNames.begin(), kVideoMapNames.end());
  check(WritePng(folder / (name + "_strip.png"), Figure(titles, rows_)));
  OutputFile plot(folder / (name + ".svg"));
  plot.Write(PlotsSvg({{PlotOf(source_, bad3_percent_)}}));
  check(plot.Commit());
}

}  // namespace sprout::evaluate
