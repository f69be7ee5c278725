#include "tests/common/scenes/scene_folder.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

namespace sprout::scenes {

void SceneFolder::Write2005(cv::Size size) const {
  WriteImage("view1.png", SomePicture(size));
  WriteImage("view5.png", SomePicture(size));
  cv::Mat1b codes(size, 40);
  codes(0, 0) = 0;
  codes(2, 3) = 60;
  WriteImage("disp1.png", codes);
}

void SceneFolder::Write2014() const {
  const cv::Size size(30, 20);
  WriteImage("im0.png", SomePicture(size));
  WriteImage("im1.png", SomePicture(size));
  cv::Mat1f disparity(size, 5.25f);
  disparity(0, 0) = INFINITY;
  disparity(2, 3) = 7.5f;
  WritePfm("disp0.pfm", disparity, "-1");
  WriteText("calib.txt",
            "cam0=[100.5 0 14.25; 0 100.5 9.5; 0 0 1]\n"
            "cam1=[100.5 0 17.5; 0 100.5 9.5; 0 0 1]\n"
            "doffs=3.25\nbaseline=193.5\nwidth=30\nheight=20\nndisp=12\n");
}

void SceneFolder::WriteImage(const std::string& name, const cv::Mat& image) const {
  ASSERT_TRUE(cv::imwrite(File(name), image)) << name;
}

void SceneFolder::WriteText(const std::string& name, const std::string& text) const {
  std::ofstream(File(name), std::ios::binary) << text;
}

void SceneFolder::WritePfm(const std::string& name, const cv::Mat1f& samples,
                           const std::string& scale) const {
  std::string text = "Pf\n" + std::to_string(samples.cols) + " " + std::to_string(samples.rows) +
                     "\n" + scale + "\n";
  const bool little_endian = scale.front() == '-';
  for (int v = samples.rows - 1; v >= 0; --v) {
    for (int u = 0; u < samples.cols; ++u) {
      const auto bits = std::bit_cast<uint32_t>(samples(v, u));
      for (int i = 0; i < 4; ++i) {
        text += static_cast<char>(bits >> (8 * (little_endian ? i : 3 - i)) & 0xff);
      }
    }
  }
  WriteText(name, text);
}

CaptureConfig SceneFolder::Config() const {
  CaptureConfig config;
  config.set_source("middlebury:" + path_.path().string());
  config.set_tof_grid_px(5);
  return config;
}

cv::Mat3b SomePicture(cv::Size size) {
  cv::Mat3b picture(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      picture(v, u) = {static_cast<uchar>(7 * u), static_cast<uchar>(11 * v),
                       static_cast<uchar>(u + v)};
    }
  }
  return picture;
}

std::string OpenError(const CaptureConfig& config) {
  try {
    OpenDataset(config);
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << config.source() << " opened, but should not";
  return "";
}

}  // namespace sprout::scenes
