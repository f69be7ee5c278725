#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/scenes/dataset.h"
#include "tests/common/scenes/scene_folder.h"

namespace sprout::scenes {

/// Made-up frames of 40×30 px in KITTI's layout, in a temporary folder. The scanner stands in the
/// left camera, its x forward and its z up; f = 100 px, cx = 20, cy = 15, b = 0.5 m, so a point
/// (x, y, z) is seen at (20 − 100·y/x, 15 − 100·z/x) with a disparity of 50/x px.
class KittiFolder {
 public:
  using Point = std::array<float, 4>;

  KittiFolder();
  explicit KittiFolder(const std::string& stereo_id) : KittiFolder() { WriteStereo(stereo_id); }

  /// A whole frame of the stereo set: truth of 5 px everywhere but at (0, 0), where it is unknown;
  /// a scan of three points, of which the left camera sees (10, 0, 0) and (20, 1, −2).
  void WriteStereo(const std::string& id) const;
  /// The same without truth, named as in the object set.
  void WriteObject(const std::string& id) const;

  void WriteScan(const std::string& id, const std::vector<Point>& points) const;
  void WriteTruth(const std::string& name, const cv::Mat1w& codes) const;
  void WriteCalibration(const std::string& id, const std::string& key = "",
                        const std::string& value = "") const;

  const SceneFolder& files() const { return files_; }
  std::string place() const { return files_.File("."); }

  /// @param rest  what follows the folder: "/000007?beams=16".
  CaptureConfig Config(const std::string& rest) const;
  std::unique_ptr<Dataset> Open(const std::string& rest) const { return OpenDataset(Config(rest)); }

  static constexpr int kWidth = 40;
  static constexpr int kHeight = 30;

 private:
  void WriteViews(const std::string& name) const;

  SceneFolder files_;
};

}  // namespace sprout::scenes
