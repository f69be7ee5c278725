#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "common/scenes/dataset.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout::scenes {

/// A scene in a temporary folder that goes away with the object.
class SceneFolder {
 public:
  enum Layout { k2014 };

  SceneFolder() = default;
  explicit SceneFolder(cv::Size size_of_2005) { Write2005(size_of_2005); }
  explicit SceneFolder(Layout) { Write2014(); }

  /// A complete scene in the layout of 2005 and 2006: colour, disp1 with code 40 except for
  /// unknown (0) at (0, 0) and 60 at (3, 2); no disp5, no dmin.txt.
  void Write2005(cv::Size size) const;

  /// A complete scene in the layout of 2014, of 30x20 px: disp0.pfm holds 5.25 px except for
  /// inf at (0, 0), the top left, and 7.5 px at (3, 2); no disp1.pfm.
  void Write2014() const;

  void WriteImage(const std::string& name, const cv::Mat& image) const;
  void WriteText(const std::string& name, const std::string& text) const;
  /// @param scale  as written into the header; below 0: little endian.
  void WritePfm(const std::string& name, const cv::Mat1f& samples, const std::string& scale) const;
  void Remove(const std::string& name) const { std::filesystem::remove(path_ / name); }

  /// Configuration that names this scene, with a ToF grid of 5 px.
  CaptureConfig Config() const;
  std::unique_ptr<Dataset> Open() const { return OpenDataset(Config()); }

  std::string File(const std::string& name) const { return (path_ / name).string(); }

 private:
  TemporaryDirectory path_;
};

/// A picture with something in every channel.
cv::Mat3b SomePicture(cv::Size size);

/// what() of the ConfigError that opening throws; fails the test when there is none.
std::string OpenError(const CaptureConfig& config);

}  // namespace sprout::scenes
