#include "services/calibrate/image_folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "common/picture/read_image.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

bool IsImage(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return std::tolower(c); });
  constexpr std::array kExtensions = {".png", ".jpg", ".jpeg", ".pgm",
                                      ".ppm", ".bmp", ".tif",  ".tiff"};
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

// The NAME of left_NAME.png or leftNAME.png, with the line; nothing when it is none of these.
std::optional<std::string> NameOf(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::string prefix = "left";
  if (!IsImage(file) || !stem.starts_with(prefix)) return std::nullopt;
  const std::string name = stem.substr(prefix.size());
  const bool is_name = name.starts_with('_') ||
                       (!name.empty() && std::isdigit(static_cast<unsigned char>(name[0])) != 0);
  return is_name ? std::optional(name) : std::nullopt;
}

// The image whose name, without extension, is `stem`; empty: there is none.
fs::path FileOf(const std::vector<fs::path>& files, const std::string& stem) {
  const auto found = std::ranges::find_if(
      files, [&](const fs::path& file) { return file.stem() == stem && IsImage(file); });
  return found == files.end() ? fs::path() : *found;
}

cv::Mat Read(const fs::path& file, int flags) {
  Result<cv::Mat> image = DecodeImageFile(file, flags, kCameraFormats);
  if (!image) throw ConfigError(image.error().text);
  return *image;
}

cv::Mat1f ReadNumbers(const fs::path& file, double scale_of_16_bits) {
  const cv::Mat image = Read(file, cv::IMREAD_UNCHANGED);
  const int type = image.type();
  if (type != CV_8UC1 && type != CV_16UC1 && type != CV_32FC1) {
    throw ConfigError(file.string() +
                      ": allowed is one channel of 8 or 16 bits or of 32-bit floating point");
  }
  cv::Mat1f numbers;
  image.convertTo(numbers, CV_32F, type == CV_32FC1 ? 1 : scale_of_16_bits);
  return numbers;
}

TofImage ReadTof(const std::vector<fs::path>& files, const std::string& name) {
  const std::string tof_name = name.starts_with('_') ? name : "_" + name;
  const fs::path amplitude = FileOf(files, "tof_amplitude" + tof_name);
  const fs::path depth = FileOf(files, "tof_depth" + tof_name);
  if (amplitude.empty() && depth.empty()) return {};
  if (amplitude.empty() || depth.empty()) {
    throw ConfigError((amplitude.empty() ? depth : amplitude).string() + ": there is no " +
                      (amplitude.empty() ? "tof_amplitude" : "tof_depth") + tof_name);
  }
  constexpr double kMPerMm = 0.001;
  TofImage tof{.depth_m = ReadNumbers(depth, kMPerMm), .amplitude = ReadNumbers(amplitude, 1)};
  if (tof.depth_m.size() != tof.amplitude.size()) {
    throw ConfigError(depth.string() + ": is not of the size of " + amplitude.string());
  }
  return tof;
}

}  // namespace

void ReadImageFolder(const std::filesystem::path& folder,
                     const std::function<void(const RigImages&)>& visit) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::ranges::sort(files);
  int triplets = 0;
  for (const fs::path& file : files) {
    const std::optional<std::string> name = NameOf(file);
    if (!name) continue;
    const fs::path right = FileOf(files, "right" + *name);
    if (right.empty()) throw ConfigError(file.string() + ": there is no right" + *name);
    visit({.left = Read(file, cv::IMREAD_GRAYSCALE),
           .right = Read(right, cv::IMREAD_GRAYSCALE),
           .tof = ReadTof(files, *name)});
    ++triplets;
  }
  if (triplets == 0) {
    throw ConfigError(
        folder.string() +
        ": no left_NAME.png with a right_NAME.png in it, nor left1.png with right1.png");
  }
}

void WriteImages(const std::filesystem::path& folder, const std::string& name,
                 const RigImages& images) {
  const auto write = [&](const std::string& what, const char* extension, const cv::Mat& image) {
    const fs::path file = folder / (what + "_" + name + extension);
    bool written = false;
    try {
      written = cv::imwrite(file.string(), image);
    } catch (const cv::Exception&) {
      // OpenCV's text is about its source.
    }
    if (!written) throw std::runtime_error(file.string() + ": cannot be written");
  };
  if (!images.tof.amplitude.empty()) {  // without it there are no corners in the ToF image
    write("tof_depth", ".tiff", images.tof.depth_m);
    write("tof_amplitude", ".tiff", images.tof.amplitude);
  }
  write("right", ".png", images.right);
  write("left", ".png", images.left);  // the last one: with it the triplet is there
}

}  // namespace sprout::calibrate
