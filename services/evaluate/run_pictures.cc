#include "services/evaluate/run_pictures.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"

namespace sprout {
namespace {

void Write(const std::filesystem::path& path, const cv::Mat3b& picture) {
  if (const Result<void> written = WritePng(path, picture); !written) {
    throw std::runtime_error(written.error().text);
  }
}

std::string CorrectText(const MethodResult& method) {
  return fmt::format("{:.1f} %", method.nonoccluded.correct_le1_percent());
}

cv::Mat3b ToBgr(const cv::Mat& image) {
  if (image.channels() == 3) return image;
  const cv::Mat planes[] = {image, image, image};
  cv::Mat3b bgr;
  cv::merge(planes, std::size(planes), bgr);
  return bgr;
}

}  // namespace

void RunPictures::Add(const Scene& scene, const SceneResult& result) {
  const cv::Mat1f& truth = scene.frame.truth.left;
  const ValueRange range_px = RobustRange({truth.begin(), truth.end()});
  titles_ = {"left image"};
  std::vector<FigureCell> row{{FigureThumbnail(ToBgr(scene.frame.left)), scene.name}};
  for (const MethodResult& method : result.methods) {
    const std::string correct = CorrectText(method);
    Write(folder_ / (scene.name + "_" + method.name + ".png"),
          DisparityPicture(FromPx(method.map_px), range_px,
                           scene.name + ", " + method.name + ": " + correct));
    titles_.push_back(method.name);
    row.push_back({FigureThumbnail(Colorize(method.map_px, range_px)), correct});
  }
  titles_.push_back("ground truth");
  row.push_back({FigureThumbnail(Colorize(truth, range_px)), ""});
  rows_.push_back(std::move(row));
}

void RunPictures::WriteFigure() const { Write(folder_ / "figure.png", Figure(titles_, rows_)); }

}  // namespace sprout
