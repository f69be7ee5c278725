#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <opencv2/core/persistence.hpp>
#include <set>
#include <string>
#include <string_view>

#include "common/config/config_error.h"
#include "common/core/joined.h"
#include "services/tools/calibrate/import/foreign_rig.h"

namespace sprout::calibrate {
namespace {

// The names of an entry, as Plain() has them.
using Names = std::vector<std::string_view>;
const std::array<Names, 2> kMatrix = {
    Names{"m1", "k1", "cameramatrix1", "leftk", "kleft", "kl", "ml", "leftcameramatrix",
          "cameramatrixleft", "cameramatrixl", "intrinsicleft", "leftm", "mleft", "mtxl", "mtx1"},
    Names{"m2", "k2", "cameramatrix2", "rightk", "kright", "kr", "mr", "rightcameramatrix",
          "cameramatrixright", "cameramatrixr", "intrinsicright", "rightm", "mright", "mtxr",
          "mtx2"}};
const std::array<Names, 2> kDistortion = {
    Names{"d1", "distcoeffs1", "distortioncoefficients1", "leftd", "dleft", "dl", "leftdistcoeffs",
          "distcoeffsleft", "distcoeffsl", "distortionleft", "distcoeff1", "distl", "dist1",
          "distleft", "leftdist"},
    Names{"d2", "distcoeffs2", "distortioncoefficients2", "rightd", "dright", "dr",
          "rightdistcoeffs", "distcoeffsright", "distcoeffsr", "distortionright", "distcoeff2",
          "distr", "dist2", "distright", "rightdist"}};
const std::array<Names, 2> kRectifyingTurn = {Names{"r1", "leftr", "rleft", "rl"},
                                              Names{"r2", "rightr", "rright", "rr"}};
const std::array<Names, 2> kProjection = {Names{"p1", "leftp", "pleft", "pl"},
                                          Names{"p2", "rightp", "pright", "pr"}};
const Names kRotation = {"r", "rotation", "rotationmatrix", "rlr", "rot"};
const Names kTranslation = {"t", "translation", "translationvector", "tlr", "trans", "trns"};
const Names kSize = {"imagesize", "size", "imgsize", "framesize", "resolution"};
const Names kWidth = {"imagewidth", "width", "leftwidth", "imgwidth"};
const Names kHeight = {"imageheight", "height", "leftheight", "imgheight"};

// Most levels of nesting; a calibration has some 4.
constexpr int kMaxDepth = 100;

// "LEFT.K" and "left_k" are one name.
std::string Plain(std::string_view name) {
  std::string plain;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) plain += static_cast<char>(std::tolower(byte));
  }
  return plain;
}

// The largest depth of nested lists, maps (YAML, JSON) and elements (XML) in a text, which OpenCV
// reads by recursion.
int DepthOf(std::string_view text) {
  int depth = 0;
  int most = 0;
  char before = ' ';
  for (size_t i = 0; i < text.size(); before = text[i++]) {
    const char c = text[i];
    const char next = i + 1 < text.size() ? text[i + 1] : ' ';
    const bool is_element = c == '<' && next != '/' && next != '?' && next != '!';
    if (c == '[' || c == '{' || is_element) most = std::max(most, ++depth);
    if (c == ']' || c == '}' || (c == '<' && next == '/') || (c == '>' && before == '/')) --depth;
  }
  return most;
}

Eigen::Matrix3d Square(const cv::Mat1d& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.ptr<double>());
}

// The reason of an exception. For a text that cannot be parsed OpenCV gives line and reason as the
// name of the function.
std::string ReasonOf(const cv::Exception& e) {
  return e.code == cv::Error::StsParseError && !e.func.empty() ? e.func : e.err;
}

// Whether two entries have the same value.
bool AreEqual(const cv::FileNode& a, const cv::FileNode& b) {
  if (a.type() != b.type() || a.size() != b.size()) return false;
  if (a.isString()) return static_cast<std::string>(a) == static_cast<std::string>(b);
  if (a.isInt() || a.isReal()) return static_cast<double>(a) == static_cast<double>(b);
  return std::equal(a.begin(), a.end(), b.begin(), AreEqual);
}

// A list of numbers, or of rows of them, as NumPy's tolist() gives it; empty where it is none.
cv::Mat1d OfLists(const cv::FileNode& node) {
  const auto is_number = [](const cv::FileNode& item) { return item.isInt() || item.isReal(); };
  const bool has_rows = node.size() > 0 && (*node.begin()).isSeq();
  const size_t columns = has_rows ? (*node.begin()).size() : 1;
  std::vector<double> numbers;
  for (const cv::FileNode& row : node) {
    if (has_rows ? !row.isSeq() || row.size() != columns : !is_number(row)) return {};
    if (!has_rows) numbers.push_back(static_cast<double>(row));
    for (size_t i = 0; has_rows && i < columns; ++i) {
      const cv::FileNode item = row[static_cast<int>(i)];
      if (!is_number(item)) return {};
      numbers.push_back(static_cast<double>(item));
    }
  }
  return cv::Mat1d(numbers, /*copyData=*/true).reshape(1, static_cast<int>(node.size()));
}

// All entries of the files, by their plain names.
class Entries {
 public:
  explicit Entries(const std::vector<ForeignFile>& files) {
    for (const ForeignFile& file : files) {
      where_ += (where_.empty() ? "" : ", ") + file.path.string();
      if (const int depth = DepthOf(file.text); depth > kMaxDepth) {
        throw ConfigError(file.path.string() + ": lists or elements within each other = " +
                          std::to_string(depth) + ", allowed: up to " + std::to_string(kMaxDepth));
      }
      try {
        // Without a given format OpenCV finds it by the beginning of the text.
        cv::FileStorage& storage =
            storages_.emplace_back(file.text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
        const cv::FileNode root = storage.root();
        for (const std::string& key : root.keys()) {
          names_ += " " + key;
          const auto [before, is_new] = nodes_.try_emplace(Plain(key), root[key]);
          if (!is_new && !AreEqual(before->second, root[key])) doubled_.insert(Plain(key));
        }
      } catch (const cv::Exception& e) {
        throw ConfigError(file.path.string() + ": OpenCV cannot read it: " + ReasonOf(e));
      }
    }
  }

  const cv::FileNode* Find(const Names& names) const {
    for (const std::string_view name : names) {
      if (const auto found = nodes_.find(std::string(name)); found != nodes_.end()) {
        if (doubled_.contains(found->first)) {
          throw ConfigError(where_ + ": " + found->second.name() +
                            " is there twice, and not the same; allowed: one of them");
        }
        return &found->second;
      }
    }
    return nullptr;
  }

  // A matrix as 64-bit floating point; empty when the file has none of these names.
  cv::Mat1d FindMatrix(const Names& names) const {
    const cv::FileNode* const node = Find(names);
    if (node == nullptr) return {};
    cv::Mat matrix;
    try {
      if (node->isSeq()) {
        matrix = OfLists(*node);
      } else {
        *node >> matrix;
      }
    } catch (const cv::Exception&) {
      matrix.release();  // made, but not filled where data has another count
    }
    if (matrix.empty() || matrix.channels() != 1 || !cv::checkRange(matrix)) {
      throw ConfigError(where_ + ": " + node->name() +
                        " is no matrix; allowed: rows, cols, dt, and as many finite numbers as "
                        "data; or a list of rows of them");
    }
    cv::Mat1d numbers;
    matrix.convertTo(numbers, CV_64F);
    return numbers;
  }

  cv::Mat1d Matrix(const Names& names, const std::vector<cv::Size>& sizes) const {
    const cv::Mat1d matrix = FindMatrix(names);
    if (std::ranges::find(sizes, matrix.size()) != sizes.end()) return matrix;
    if (!matrix.empty()) {
      throw ConfigError(where_ + ": " + Find(names)->name() + " has " +
                        std::to_string(matrix.rows) + "x" + std::to_string(matrix.cols) +
                        " numbers; allowed: " + std::to_string(sizes[0].height) + "x" +
                        std::to_string(sizes[0].width));
    }
    throw Missing(names);
  }

  Eigen::Matrix3d Rotation(const Names& names) const {
    const cv::Mat1d matrix = Matrix(names, {{3, 3}});
    const Eigen::Matrix3d rotation = Square(matrix);
    RequireRotation(where_ + ": " + Find(names)->name(), rotation);
    return rotation;
  }

  // T and P2 of one calibration have one baseline; of another board, unit or rig one of the two is.
  void RequireOneBaseline(const cv::Mat1d& t) const {
    const cv::Mat1d p = FindMatrix(kProjection[1]);
    if (p.size() != cv::Size(4, 3) || p(0, 0) == 0) return;
    constexpr double kRounding = 0.01;
    const double of_t = cv::norm(t);
    const double of_p = std::hypot(p(0, 3), p(1, 3)) / std::abs(p(0, 0));
    if (std::abs(of_t - of_p) <= kRounding * of_t) return;
    throw ConfigError(where_ + ": the length of T is " + cv::format("%g", of_t) + ", " +
                      Find(kProjection[1])->name() + " has a baseline of " +
                      cv::format("%g", of_p) + "; allowed: the same, or one of the two");
  }

  ConfigError Missing(const Names& names) const {
    return ConfigError(where_ + ": no entry with one of the names " + Joined(", ", names) +
                       " (capitals, dots and underscores do not matter); there are:" + names_);
  }

  cv::Size ImageSize() const {
    cv::Size size;
    const cv::FileNode* const both = Find(kSize);
    if (both != nullptr && (both->isSeq() || (both->isMap() && !(*both)["data"].empty()))) {
      const cv::Mat1d numbers = FindMatrix(kSize);
      if (numbers.total() == 2) size = cv::Size2d(numbers(0), numbers(1));
    }
    const cv::FileNode* const width = Find(kWidth);
    const cv::FileNode* const height = Find(kHeight);
    if (width != nullptr && height != nullptr) {
      size = {static_cast<int>(*width), static_cast<int>(*height)};
    }
    return size;
  }

 private:
  std::vector<cv::FileStorage> storages_;
  std::map<std::string, cv::FileNode> nodes_;
  std::set<std::string> doubled_;  // names of entries of two values
  std::string where_;
  std::string names_;
};

ForeignCamera CameraOf(const Entries& entries, size_t which) {
  ForeignCamera camera{.name = which == 0 ? "left camera" : "right camera",
                       .size = entries.ImageSize(),
                       .k = Square(entries.Matrix(kMatrix[which], {{3, 3}})),
                       .distortion = {}};
  const cv::Mat1d distortion = entries.FindMatrix(kDistortion[which]);
  if (distortion.empty()) throw entries.Missing(kDistortion[which]);
  camera.distortion.assign(distortion.begin(), distortion.end());
  return camera;
}

ForeignRectification RectifiedOf(const Entries& entries, size_t which) {
  const cv::Mat1d p = entries.Matrix(kProjection[which], {{4, 3}});
  return {.rotation = entries.Rotation(kRectifyingTurn[which]), .tx = p(0, 3), .focal_px = p(0, 0)};
}

}  // namespace

bool IsOpencvFile(const ForeignFile& file) {
  const std::string_view text = file.text;
  return text.starts_with("<?xml") || text.starts_with("{") ||
         text.find("!!opencv-matrix") != std::string_view::npos;
}

ForeignRig ReadOpencvRig(const std::vector<ForeignFile>& files) {
  const Entries entries(files);
  ForeignRig rig{
      .left = CameraOf(entries, 0), .right = CameraOf(entries, 1), .left_from_right = {}};
  if (entries.Find(kTranslation) == nullptr && entries.Find(kProjection[1]) != nullptr) {
    rig.left_from_right = PoseOfRectified(RectifiedOf(entries, 0), RectifiedOf(entries, 1));
    return rig;
  }
  // OpenCV's R and T take points of the left camera to the right one.
  const Eigen::Matrix3d rotation = entries.Rotation(kRotation);
  const cv::Mat1d t = entries.Matrix(kTranslation, {{1, 3}, {3, 1}});
  entries.RequireOneBaseline(t);
  const Pose right_from_left{.rotation = Eigen::Quaterniond(rotation).normalized(),
                             .translation_m = {t(0), t(1), t(2)}};
  rig.left_from_right = right_from_left.Inverse();
  return rig;
}

}  // namespace sprout::calibrate
