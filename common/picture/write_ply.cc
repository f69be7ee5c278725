#include "common/picture/write_ply.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>

#include "common/core/image.h"
#include "common/core/output_file.h"
#include "common/geometry/projection.h"

namespace sprout {
namespace {

/// A disparity map, its calibration and its colours, of one size.
struct Surface {
  const RectifiedPair& pair;
  const DisparityImage& disparity;
  const cv::Mat& left;
  const cv::Mat& confidence;  // empty: none

  bool HasVertex(int u, int v) const {
    return disparity.IsValid(u, v) && double{disparity.Px(u, v)} + pair.cx_right - pair.cx > 0;
  }
};

Result<void> CheckSizes(const std::filesystem::path& path, const Surface& surface) {
  const cv::Size size = surface.disparity.size();
  const bool has_confidence = !surface.confidence.empty();
  if (has_confidence &&
      (surface.confidence.size() != size || surface.confidence.type() != CV_8UC1)) {
    return Fail("cannot write " + path.string() + ": confidence " +
                SizeText(surface.confidence.size()) + ": allowed is " + SizeText(size) +
                ", in grey");
  }
  if (surface.pair.size() == size && surface.left.size() == size) return {};
  return Fail("cannot write " + path.string() + ": disparity map " + SizeText(size) +
              ", left image " + SizeText(surface.left.size()) + " and calibration " +
              SizeText(surface.pair.size()) + " differ in size");
}

/// Number of each pixel's vertex in the file; −1 = none.
cv::Mat1i NumberVertices(const Surface& surface, int& count) {
  cv::Mat1i numbers(surface.disparity.size(), -1);
  count = 0;
  for (int v = 0; v < numbers.rows; ++v) {
    for (int u = 0; u < numbers.cols; ++u) {
      if (surface.HasVertex(u, v)) numbers(v, u) = count++;
    }
  }
  return numbers;
}

void WriteHeader(OutputFile& file, int vertices, bool has_confidence) {
  file.Write(
      "ply\n"
      "format binary_little_endian 1.0\n"
      "comment left rectified camera frame, metres: x right, y down, z forward\n"
      "element vertex " +
      std::to_string(vertices) +
      "\n"
      "property float x\n"
      "property float y\n"
      "property float z\n"
      "property uchar red\n"
      "property uchar green\n"
      "property uchar blue\n");
  if (has_confidence) file.Write("property uchar confidence\n");
}

void WriteVertices(OutputFile& file, const Surface& surface, const cv::Mat1i& numbers) {
  const bool grey = surface.left.channels() == 1;
  for (int v = 0; v < numbers.rows; ++v) {
    for (int u = 0; u < numbers.cols; ++u) {
      if (numbers(v, u) < 0) continue;
      const Eigen::Vector3f point = PointAt(surface.pair, surface.disparity, u, v).cast<float>();
      for (float coordinate : point) file.WriteNumber(coordinate);
      const cv::Vec3b bgr =
          grey ? cv::Vec3b::all(surface.left.at<uchar>(v, u)) : surface.left.at<cv::Vec3b>(v, u);
      for (int channel : {2, 1, 0}) file.WriteNumber(bgr[channel]);
      if (!surface.confidence.empty()) file.WriteNumber(surface.confidence.at<uchar>(v, u));
    }
  }
}

constexpr int kMaxJumpCounts = static_cast<int>(kMaxMeshJumpPx * DisparityImage::kCountsPerPixel);

/// Calls visit(i, j, k) with the vertex numbers of every triangle of the mesh.
template <typename Visit>
void ForEachTriangle(const DisparityImage& disparity, const cv::Mat1i& numbers, Visit visit) {
  const auto jump = [&](cv::Point p, cv::Point q) {
    if (numbers(p) < 0 || numbers(q) < 0) return std::numeric_limits<int>::max();
    return std::abs(disparity.counts()(p) - disparity.counts()(q));
  };
  const auto offer = [&](cv::Point p, cv::Point q, cv::Point r) {
    if (std::max({jump(p, q), jump(q, r), jump(r, p)}) > kMaxJumpCounts) return;
    visit(numbers(p), numbers(q), numbers(r));
  };
  for (int v = 0; v + 1 < numbers.rows; ++v) {
    for (int u = 0; u + 1 < numbers.cols; ++u) {
      const cv::Point a(u, v);
      const cv::Point b(u + 1, v);
      const cv::Point c(u, v + 1);
      const cv::Point d(u + 1, v + 1);
      // A missing corner counts as an infinite jump, so the other three still make a triangle.
      if (jump(a, d) <= jump(b, c)) {
        offer(a, c, d);
        offer(a, d, b);
      } else {
        offer(a, c, b);
        offer(b, c, d);
      }
    }
  }
}

}  // namespace

Result<void> WriteCloudPly(const std::filesystem::path& path, const RectifiedPair& pair,
                           const DisparityImage& disparity, const cv::Mat& left,
                           const cv::Mat& confidence) {
  const Surface surface{pair, disparity, left, confidence};
  if (auto sizes = CheckSizes(path, surface); !sizes) return sizes;
  int vertices = 0;
  const cv::Mat1i numbers = NumberVertices(surface, vertices);
  OutputFile file(path);
  WriteHeader(file, vertices, !confidence.empty());
  file.Write("end_header\n");
  WriteVertices(file, surface, numbers);
  return file.Commit();
}

Result<void> WriteMeshPly(const std::filesystem::path& path, const RectifiedPair& pair,
                          const DisparityImage& disparity, const cv::Mat& left,
                          const cv::Mat& confidence) {
  const Surface surface{pair, disparity, left, confidence};
  if (auto sizes = CheckSizes(path, surface); !sizes) return sizes;
  int vertices = 0;
  const cv::Mat1i numbers = NumberVertices(surface, vertices);
  int triangles = 0;  // the header comes first, so count before writing
  ForEachTriangle(disparity, numbers, [&triangles](int, int, int) { ++triangles; });
  OutputFile file(path);
  WriteHeader(file, vertices, !confidence.empty());
  file.Write("element face " + std::to_string(triangles) +
             "\nproperty list uchar int vertex_indices\nend_header\n");
  WriteVertices(file, surface, numbers);
  ForEachTriangle(disparity, numbers, [&file](int i, int j, int k) {
    file.WriteNumber(uint8_t{3});
    for (int32_t number : {i, j, k}) file.WriteNumber(number);
  });
  return file.Commit();
}

}  // namespace sprout
