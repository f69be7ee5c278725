#include "services/tools/calibrate/image_folder.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string_view>

#include "common/config/required.h"
#include "common/core/image.h"
#include "common/core/output_file.h"
#include "common/core/pair_names.h"
#include "common/picture/eight_bits.h"
#include "common/picture/read_image.h"
#include "common/picture/write_image.h"
#include "common/scenes/pfm.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

bool IsImage(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return std::tolower(c); });
  constexpr std::array kExtensions = {".png", ".jpg", ".jpeg", ".pgm", ".ppm",
                                      ".bmp", ".tif", ".tiff", ".pfm"};
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

bool HasLine(const std::string& name) { return name.starts_with('_') || name.starts_with('-'); }

// The NAME of left_NAME.png, left-NAME.png or left1.png, with the line; nothing when it is none of
// these.
std::optional<std::string> NameOf(const fs::path& file, std::string_view prefix) {
  const std::string stem = file.stem().string();
  if (!IsImage(file) || !stem.starts_with(prefix)) return std::nullopt;
  const std::string name = stem.substr(prefix.size());
  const bool is_name =
      HasLine(name) || (!name.empty() && std::isdigit(static_cast<unsigned char>(name[0])) != 0);
  return is_name ? std::optional(name) : std::nullopt;
}

// The image whose name, without extension, is `stem`; empty: there is none.
fs::path FileOf(const std::vector<fs::path>& files, const std::string& stem) {
  const auto found = std::ranges::find_if(
      files, [&](const fs::path& file) { return file.stem() == stem && IsImage(file); });
  return found == files.end() ? fs::path() : *found;
}

// Reads amplitudes, which may have any unit.
cv::Mat1f ReadAmplitude(const fs::path& file) {
  const cv::Mat image = Required(DecodeImageFile(file, cv::IMREAD_UNCHANGED, kCameraFormats));
  const int type = image.type();
  if (type != CV_8UC1 && type != CV_16UC1 && type != CV_32FC1) {
    throw ConfigError(file.string() +
                      ": allowed is one channel of 8 or 16 bits or of 32-bit floating point");
  }
  cv::Mat1f amplitude;
  image.convertTo(amplitude, CV_32F);
  return amplitude;
}

TofImage ReadTof(const std::vector<fs::path>& files, const std::string& name) {
  const std::string tof_name = HasLine(name) ? name : "_" + name;
  const fs::path amplitude = FileOf(files, "tof_amplitude" + tof_name);
  const fs::path depth = FileOf(files, "tof_depth" + tof_name);
  if (amplitude.empty() && depth.empty()) return {};
  if (amplitude.empty() || depth.empty()) {
    throw ConfigError((amplitude.empty() ? depth : amplitude).string() + ": there is no " +
                      (amplitude.empty() ? "tof_amplitude" : "tof_depth") + tof_name);
  }
  TofImage tof{.depth_m = Required(scenes::ReadRangeFile(depth)),
               .amplitude = ReadAmplitude(amplitude)};
  if (tof.depth_m.size() != tof.amplitude.size()) {
    throw ConfigError(depth.string() + ": is not of the size of " + amplitude.string());
  }
  return tof;
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

// The images called "PREFIX_NAME" or "PREFIX1"; where there are none, those in a folder PREFIX.
std::vector<std::string> FilesOf(const fs::path& folder, std::string_view prefix) {
  std::vector<std::string> found;
  for (const fs::path& file : FilesIn(folder)) {
    if (NameOf(file, prefix)) found.push_back(file);
  }
  if (!found.empty() || !fs::is_directory(folder / prefix)) return found;
  for (const fs::path& file : FilesIn(folder / prefix)) {
    if (IsImage(file)) found.push_back(file);
  }
  return found;
}

// Notes for the user: images without a partner, how bits were used.
std::vector<std::string> NotesOf(const fs::path& folder, const PairedNames& paired,
                                 const std::vector<std::string>& lefts,
                                 const std::vector<std::string>& rights) {
  std::vector<std::string> notes;
  for (const size_t i : paired.alone_first) notes.push_back(lefts[i] + ": has no right image");
  for (const size_t i : paired.alone_second) notes.push_back(rights[i] + ": has no left image");
  if (paired.by == PairedBy::kOrder) {
    notes.push_back(folder.string() +
                    ": left and right images belong together in the order of their names: nothing "
                    "in these says more");
  }
  return notes;
}

}  // namespace

std::vector<std::string> ReadImageFolder(const std::filesystem::path& folder, int bits,
                                         const std::function<void(const RigImages&)>& visit) {
  const std::vector<fs::path> files = FilesIn(folder);
  const std::vector<std::string> lefts = FilesOf(folder, "left");
  const std::vector<std::string> rights = FilesOf(folder, "right");
  if (lefts.empty() || rights.empty()) {
    throw ConfigError(folder.string() +
                      ": no left_NAME.png with a right_NAME.png in it, nor left1.png with "
                      "right1.png, nor folders "
                      "left and right with images");
  }
  const PairedNames paired = Required(PairNames(lefts, rights), folder.string() + ": ");
  std::vector<std::string> notes = NotesOf(folder, paired, lefts, rights);
  EightBits eight_bits(bits);
  for (const auto& [first, second] : paired.pairs) {
    CameraImage left = Required(ReadCameraImage(lefts[first]));
    CameraImage right = Required(ReadCameraImage(rights[second]));
    eight_bits.Convert({&left, &right});
    if (std::string note = eight_bits.TakeNote(); !note.empty()) {
      notes.push_back(lefts[first] + ": " + note);
    }
    const auto name = NameOf(lefts[first], "left");
    visit({.left = ToGrey(left.pixels),
           .right = ToGrey(right.pixels),
           .tof = name ? ReadTof(files, *name) : TofImage()});
  }
  return notes;
}

void WriteImages(const std::filesystem::path& folder, const std::string& name,
                 const RigImages& images) {
  const auto write = [&](const std::string& what, const char* extension, const cv::Mat& image) {
    std::vector<uchar> bytes;
    cv::imencode(extension, image, bytes);
    OutputFile file(folder / (what + "_" + name + extension));
    file.Write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    RequireWritten(file.Commit());
  };
  if (!images.tof.amplitude.empty()) {  // without it there are no corners in the ToF image
    write("tof_depth", ".tiff", images.tof.depth_m);
    write("tof_amplitude", ".tiff", images.tof.amplitude);
  }
  write("right", ".png", images.right);
  write("left", ".png", images.left);  // last: a left image shows that the triplet is complete
}

}  // namespace sprout::calibrate
