#include "common/picture/write_ply.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <array>
#include <fstream>
#include <set>

#include "common/geometry/projection.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 12;
constexpr int kHeight = 8;
const RectifiedPair kPair{.width = kWidth,
                          .height = kHeight,
                          .focal_px = 100,
                          .cx = 5.5,
                          .cy = 3.5,
                          .cx_right = 7.5,
                          .baseline_m = 0.1};

struct Vertex {
  Eigen::Vector3f point;
  cv::Vec3b rgb;
};

struct Ply {
  std::vector<std::string> header;
  std::vector<Vertex> vertices;
  std::vector<std::array<int32_t, 3>> faces;
  bool ends_with_last_element = false;
};

template <typename T>
T Take(std::istream& in) {
  T value{};
  in.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}

int CountInHeader(const Ply& ply, const std::string& element) {
  for (const std::string& line : ply.header) {
    if (line.starts_with("element " + element + " "))
      return std::stoi(line.substr(9 + element.size()));
  }
  return 0;
}

Ply ReadPly(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  Ply ply;
  for (std::string line; std::getline(in, line) && line != "end_header";)
    ply.header.push_back(line);
  for (int i = CountInHeader(ply, "vertex"); i > 0; --i) {
    Vertex vertex;
    for (int axis = 0; axis < 3; ++axis) vertex.point[axis] = Take<float>(in);
    for (int channel = 0; channel < 3; ++channel) vertex.rgb[channel] = Take<uint8_t>(in);
    ply.vertices.push_back(vertex);
  }
  for (int i = CountInHeader(ply, "face"); i > 0; --i) {
    EXPECT_EQ(Take<uint8_t>(in), 3);
    auto& face = ply.faces.emplace_back();
    for (int32_t& index : face) index = Take<int32_t>(in);
  }
  ply.ends_with_last_element = in.good() && in.peek() == std::ifstream::traits_type::eof();
  return ply;
}

cv::Mat3b Left() {
  cv::Mat3b left(kHeight, kWidth);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) left(v, u) = cv::Vec3b(uchar(u), uchar(v), uchar(200 + u));
  }
  return left;
}

template <typename DisparityPx>
DisparityImage MapOf(DisparityPx disparity_px) {
  DisparityImage disparity(kPair.size());
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) disparity.counts()(v, u) = ToCounts(disparity_px(u, v));
  }
  return disparity;
}

Ply Mesh(const DisparityImage& disparity) {
  const TemporaryDirectory directory;
  const auto written = WriteMeshPly(directory / "mesh.ply", kPair, disparity, Left());
  EXPECT_TRUE(written) << written.error().text;
  return ReadPly(directory / "mesh.ply");
}

Ply Cloud(const DisparityImage& disparity, const cv::Mat& left) {
  const TemporaryDirectory directory;
  const auto written = WriteCloudPly(directory / "cloud.ply", kPair, disparity, left);
  EXPECT_TRUE(written) << written.error().text;
  return ReadPly(directory / "cloud.ply");
}

constexpr size_t kCells = (kWidth - 1) * (kHeight - 1);

TEST(WriteCloudPly, DeclaresTheStandardHeader) {
  EXPECT_THAT(Cloud(MapOf([](int, int) { return 4; }), Left()).header,
              testing::ElementsAre(
                  "ply", "format binary_little_endian 1.0", testing::StartsWith("comment "),
                  "element vertex 96", "property float x", "property float y", "property float z",
                  "property uchar red", "property uchar green", "property uchar blue"));
}

TEST(WriteCloudPly, PutsEachPixelWhereItsDisparitySaysInItsColor) {
  const DisparityImage disparity = MapOf([](int u, int v) { return 3 + u / 32.0 + v; });
  const Ply cloud = Cloud(disparity, Left());
  ASSERT_TRUE(cloud.ends_with_last_element);
  ASSERT_EQ(cloud.vertices.size(), static_cast<size_t>(kWidth * kHeight));
  auto vertex = cloud.vertices.begin();
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u, ++vertex) {
      const auto column = static_cast<float>(u);
      const Eigen::Vector3d expected = PointFromSeed(
          kPair, {.u = column, .v = static_cast<float>(v), .u_right = column - disparity.Px(u, v)});
      EXPECT_LT((vertex->point.cast<double>() - expected).norm(), 1e-6) << u << ", " << v;
      EXPECT_EQ(vertex->rgb, cv::Vec3b(uchar(200 + u), uchar(v), uchar(u)));
    }
  }
}

TEST(WriteCloudPly, TakesAGreyImage) {
  const Ply cloud = Cloud(MapOf([](int, int) { return 4; }), cv::Mat1b(kPair.size(), uchar{99}));
  EXPECT_EQ(cloud.vertices.at(5).rgb, cv::Vec3b(99, 99, 99));
}

TEST(WriteCloudPly, SkipsPixelsWithoutDisparityOrPositiveDepth) {
  DisparityImage disparity = MapOf([](int, int) { return 4; });
  disparity.counts()(0, 0) = DisparityImage::kInvalid;
  disparity.counts()(1, 0) = ToCounts(-2);        // infinitely far: cx − cx_right
  disparity.counts()(2, 0) = ToCounts(-3);        // behind the camera
  disparity.counts()(3, 0) = ToCounts(-1.96875);  // very far
  const Ply cloud = Cloud(disparity, Left());
  EXPECT_EQ(cloud.vertices.size(), static_cast<size_t>(kWidth * kHeight - 3));
  for (const Vertex& vertex : cloud.vertices) {
    EXPECT_TRUE(std::isfinite(vertex.point.z()) && vertex.point.z() > 0);
  }
}

TEST(WriteCloudPly, WritesAnEmptyCloud) {
  const Ply cloud = Cloud(DisparityImage(kPair.size()), Left());
  EXPECT_THAT(cloud.header, testing::Contains("element vertex 0"));
}

TEST(WriteMeshPly, DeclaresFacesAsViewersExpectThem) {
  EXPECT_THAT(
      Mesh(MapOf([](int, int) { return 4; })).header,
      testing::IsSupersetOf({"element face 154", "property list uchar int vertex_indices"}));
}

TEST(WriteMeshPly, KeepsASlantedSurfaceAtWholeDisparitiesWhole) {
  for (int slant : {-1, 1}) {
    const Ply mesh = Mesh(MapOf([slant](int u, int v) { return 40 + slant * (u - v); }));
    EXPECT_EQ(mesh.faces.size(), 2 * kCells);
    const Ply other_diagonal = Mesh(MapOf([slant](int u, int v) { return 40 + slant * (u + v); }));
    EXPECT_EQ(other_diagonal.faces.size(), 2 * kCells);
  }
}

TEST(WriteMeshPly, CutsADepthStep) {
  const Ply mesh =
      Mesh(MapOf([](int u, int) { return u < 5 ? 20.0 : 20.0 - kMaxMeshJumpPx - 1 / 32.0; }));
  EXPECT_EQ(mesh.faces.size(), 2 * (kCells - (kHeight - 1)));
  for (const auto& face : mesh.faces) {
    std::set<int> sides;
    for (int index : face) sides.insert(index % kWidth < 5 ? 0 : 1);
    EXPECT_EQ(sides.size(), 1U) << "a triangle spans the step";
  }
}

TEST(WriteMeshPly, KeepsAStepOfTheTolerance) {
  const Ply mesh = Mesh(MapOf([](int u, int) { return u < 5 ? 20.0 : 20.0 - kMaxMeshJumpPx; }));
  EXPECT_EQ(mesh.faces.size(), 2 * kCells);
}

TEST(WriteMeshPly, KeepsTheThreeOtherCornersOfACellWithAHole) {
  DisparityImage disparity = MapOf([](int, int) { return 4; });
  disparity.counts()(3, 5) = DisparityImage::kInvalid;
  // Four cells touch the hole and keep one triangle each.
  EXPECT_EQ(Mesh(disparity).faces.size(), 2 * kCells - 4);
}

TEST(WriteMeshPly, TurnsAllNormalsTowardsTheCamera) {
  DisparityImage disparity = MapOf([](int u, int v) { return 30 + u - 1.5 * (v % 2); });
  disparity.counts()(3, 5) = DisparityImage::kInvalid;
  const Ply mesh = Mesh(disparity);
  ASSERT_TRUE(mesh.ends_with_last_element);
  ASSERT_GT(mesh.faces.size(), kCells);
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f p = mesh.vertices.at(static_cast<size_t>(face[0])).point;
    const Eigen::Vector3f q = mesh.vertices.at(static_cast<size_t>(face[1])).point;
    const Eigen::Vector3f r = mesh.vertices.at(static_cast<size_t>(face[2])).point;
    EXPECT_LT((q - p).cross(r - p).dot(p), 0);
  }
}

TEST(WriteMeshPly, RefusesSizesThatDiffer) {
  const TemporaryDirectory directory;
  EXPECT_THAT(
      WhyNot(WriteMeshPly(directory / "mesh.ply", kPair, DisparityImage(cv::Size(3, 3)), Left())),
      HasSubstr("mesh.ply: disparity map 3x3"));
  EXPECT_EQ(directory.CountEntries(), 0);
}

TEST(WritePly, HasTheConfidenceOfEachVertexWhenThereIsOne) {
  const TemporaryDirectory directory;
  const DisparityImage disparity = MapOf([](int, int) { return 4; });
  cv::Mat1b confidence(disparity.size());
  for (int i = 0; i < kWidth * kHeight; ++i) {
    confidence(i / kWidth, i % kWidth) = static_cast<uint8_t>(10 + i);
  }
  for (const auto& write : {WriteMeshPly, WriteCloudPly}) {
    ASSERT_TRUE(write(directory / "surface.ply", kPair, disparity, Left(), confidence));
    const std::string text = FileText(directory / "surface.ply");
    EXPECT_THAT(text, HasSubstr("property uchar blue\nproperty uchar confidence\n"));
    const char* const vertices = text.data() + text.find("end_header\n") + 11;
    constexpr int kVertexBytes = 3 * 4 + 3 + 1;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      EXPECT_EQ(vertices[kVertexBytes * (i + 1) - 1], static_cast<char>(10 + i)) << i;
    }
    EXPECT_FALSE(write(directory / "none.ply", kPair, disparity, Left(), cv::Mat1b(1, 1)));
  }
}

TEST(WriteMeshPly, RefusesAnUnwritablePath) {
  const TemporaryDirectory directory;
  const DisparityImage disparity = MapOf([](int, int) { return 4; });
  for (const auto& write : {WriteMeshPly, WriteCloudPly}) {
    EXPECT_THAT(
        WhyNot(write(directory / "missing/surface.ply", kPair, disparity, Left(), cv::Mat())),
        HasSubstr("missing/surface.ply: No such file"));
  }
  EXPECT_EQ(directory.CountEntries(), 0);
}

}  // namespace
}  // namespace sprout
