// Calibrations that other programs have made.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/persistence.hpp>

#include "common/config/required.h"
#include "services/tools/calibrate/import/foreign_rig.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A pair with everything that a pair may have, by OpenCV's own types.
struct Truth {
  cv::Size size{640, 480};
  cv::Matx33d k1{500.25, 0, 322.5, 0, 501.5, 241.25, 0, 0, 1};
  cv::Matx33d k2{498.75, 0, 318.5, 0, 499.5, 238.25, 0, 0, 1};
  std::vector<double> d1{-0.28, 0.07, 1e-4, -2e-4, 0.01};
  std::vector<double> d2{-0.27, 0.06, -3e-4, 2e-4, 0.02};
  cv::Matx33d r;
  cv::Vec3d t{-0.12, 0.002, -0.003};
  Truth() { cv::Rodrigues(cv::Vec3d(0.01, -0.02, 0.03), r); }
};

void ExpectLens(const ForeignCamera& camera, const cv::Matx33d& k, const std::vector<double>& d,
                double accuracy = 1e-9) {
  const LensFit fit = Required(ToLens(camera));
  EXPECT_NEAR(fit.lens.fx, k(0, 0), accuracy);
  EXPECT_NEAR(fit.lens.fy, k(1, 1), accuracy);
  EXPECT_NEAR(fit.lens.cx, k(0, 2), accuracy);
  EXPECT_NEAR(fit.lens.cy, k(1, 2), accuracy);
  for (size_t i = 0; i < d.size(); ++i) EXPECT_NEAR(fit.lens.distortion[i], d[i], accuracy) << i;
}

void ExpectTruth(const ForeignRig& rig, const Truth& truth, double accuracy = 1e-9) {
  ExpectLens(rig.left, truth.k1, truth.d1, accuracy);
  ExpectLens(rig.right, truth.k2, truth.d2, accuracy);
  // x_right = R x_left + T.
  const Pose back = rig.left_from_right.Inverse();
  const Eigen::Matrix3d r = back.rotation.toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(back.translation_m(i), truth.t(i), accuracy);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(r(i, k), truth.r(i, k), accuracy);
  }
}

const std::vector<std::string> kNames = {"M1", "D1", "M2", "D2", "R", "T"};

std::string Refusal(const std::vector<fs::path>& files) {
  return Thrown<ConfigError>([&] { ReadForeignRig(files); });
}

class Import : public testing::Test {
 protected:
  fs::path Write(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  // The entries under names as a program has them: K1, D1, K2, D2, R, T.
  fs::path WriteOpencv(const char* name, const std::vector<std::string>& names, bool with_size,
                       const Truth& truth) const {
    cv::FileStorage file(folder_ / name, cv::FileStorage::WRITE);
    if (with_size) {
      file << "image_width" << truth.size.width << "image_height" << truth.size.height;
    }
    file << names[0] << cv::Mat(truth.k1) << names[1] << cv::Mat(truth.d1) << names[2]
         << cv::Mat(truth.k2) << names[3] << cv::Mat(truth.d2) << names[4] << cv::Mat(truth.r)
         << names[5] << cv::Mat(truth.t);
    return folder_ / name;
  }
  fs::path WriteOpencv(const char* name, const std::vector<std::string>& names,
                       bool with_size = true) const {
    return WriteOpencv(name, names, with_size, truth_);
  }

  const TemporaryDirectory folder_;
  const Truth truth_;
};

TEST_F(Import, OpencvsFilesUnderAnyOfTheirNames) {
  const std::vector<std::vector<std::string>> all_names = {
      {"M1", "D1", "M2", "D2", "R", "T"},
      {"cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "R", "T"},
      {"camera_matrix_left", "dist_coeffs_left", "camera_matrix_right", "dist_coeffs_right", "R",
       "T"},
      {"K_l", "D_l", "K_r", "D_r", "R", "T"},
      {"mtxL", "distL", "mtxR", "distR", "Rot", "Trns"}};
  for (const auto& names : all_names) {
    for (const char* file : {"stereo.yml", "stereo.xml", "stereo.json"}) {
      const ForeignRig rig = ReadForeignRig({WriteOpencv(file, names)});
      ExpectTruth(rig, truth_);
      EXPECT_EQ(rig.left.size, truth_.size);
    }
  }
}

// json.dump() of the arrays' tolist(); the size as an array, as FileStorage of Python has it.
TEST_F(Import, ListsOfPython) {
  const auto lists = [](const cv::Mat& matrix) {
    std::string text;
    for (int row = 0; row < matrix.rows; ++row) {
      text += row == 0 ? "[[" : "], [";
      for (int i = 0; i < matrix.cols; ++i) {
        text += fmt::format("{}{:.17g}", i == 0 ? "" : ", ", matrix.at<double>(row, i));
      }
    }
    return text + "]]";
  };
  const std::string json = fmt::format(
      R"({{"M1": {}, "D1": {}, "M2": {}, "D2": {}, "R": {}, "T": [{:.17g}, {:.17g}, {:.17g}],
          "image_size": {{"type_id": "opencv-matrix", "rows": 2, "cols": 1, "dt": "i", "data": [640, 480]}}}})",
      lists(cv::Mat(truth_.k1)), lists(cv::Mat(truth_.d1)), lists(cv::Mat(truth_.k2)),
      lists(cv::Mat(truth_.d2)), lists(cv::Mat(truth_.r)), truth_.t.val[0], truth_.t.val[1],
      truth_.t.val[2]);
  const ForeignRig rig = ReadForeignRig({Write("stereo.json", json)});
  ExpectTruth(rig, truth_);
  EXPECT_EQ(rig.left.size, truth_.size);
  EXPECT_THAT(Refusal({Write("words.json", R"({"M1": [["a", 2]]})")}),
              HasSubstr("M1 is no matrix"));
}

// As OpenCV's stereo_calib writes them: without the size of the images.
TEST_F(Import, OpencvsIntrinsicsAndExtrinsics) {
  cv::FileStorage intrinsics(folder_ / "intrinsics.yml", cv::FileStorage::WRITE);
  intrinsics << "M1" << cv::Mat(truth_.k1) << "D1" << cv::Mat(truth_.d1) << "M2"
             << cv::Mat(truth_.k2) << "D2" << cv::Mat(truth_.d2);
  intrinsics.release();
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(truth_.k1, truth_.d1, truth_.k2, truth_.d2, truth_.size, truth_.r, truth_.t, r1,
                    r2, p1, p2, q);
  cv::FileStorage extrinsics(folder_ / "extrinsics.yml", cv::FileStorage::WRITE);
  extrinsics << "R" << cv::Mat(truth_.r) << "T" << cv::Mat(truth_.t) << "R1" << r1 << "R2" << r2
             << "P1" << p1 << "P2" << p2 << "Q" << q;
  extrinsics.release();
  const ForeignRig rig = ReadForeignRig({folder_ / "intrinsics.yml", folder_ / "extrinsics.yml"});
  ExpectTruth(rig, truth_);
  EXPECT_TRUE(rig.left.size.empty());
  EXPECT_THAT(Refusal({folder_ / "intrinsics.yml"}),
              HasSubstr("intrinsics.yml: no entry with one of the names r, rotation, "));
  cv::FileStorage mixed(folder_ / "mixed.yml", cv::FileStorage::WRITE);
  mixed << "R" << cv::Mat(truth_.r) << "T" << cv::Mat(1.02 * truth_.t) << "P2" << p2;
  mixed.release();
  EXPECT_THAT(Refusal({folder_ / "intrinsics.yml", folder_ / "mixed.yml"}),
              HasSubstr("mixed.yml: the length of T is 0.122455, P2 has a baseline of 0.120054; "));
}

// A file with R1, P1, R2, P2 alone describes a pair as well.
TEST_F(Import, OpencvsRectificationInsteadOfRAndT) {
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(truth_.k1, truth_.d1, truth_.k2, truth_.d2, truth_.size, truth_.r, truth_.t, r1,
                    r2, p1, p2, q);
  const fs::path path = folder_ / "euroc.yaml";
  cv::FileStorage file(path, cv::FileStorage::WRITE);
  file << "LEFT_height" << 480 << "LEFT_width" << 640 << "LEFT_K" << cv::Mat(truth_.k1) << "LEFT_D"
       << cv::Mat(truth_.d1) << "LEFT_R" << r1 << "LEFT_P" << p1 << "RIGHT_K" << cv::Mat(truth_.k2)
       << "RIGHT_D" << cv::Mat(truth_.d2) << "RIGHT_R" << r2 << "RIGHT_P" << p2;
  file.release();
  // OpenCV reads names with dots, but does not write them.
  std::string text = FileText(path);
  std::ranges::replace(text, '_', '.');
  std::ofstream(path) << text;
  const ForeignRig rig = ReadForeignRig({folder_ / "euroc.yaml"});
  ExpectTruth(rig, truth_);
  EXPECT_EQ(rig.right.size, truth_.size);
}

TEST_F(Import, SaysWhatOfOpencvsFileIsMissing) {
  const fs::path file = WriteOpencv("half.yml", {"LEFT_K", "D1", "other", "D2", "R", "T"});
  EXPECT_THAT(Refusal({file}),
              HasSubstr("half.yml: no entry with one of the names m2, k2, cameramatrix2, "));
  EXPECT_THAT(Refusal({file}),
              HasSubstr("there are: image_width image_height LEFT_K D1 other D2 R T"));
  EXPECT_THAT(Refusal({Write("bad.yml", "%YAML:1.0\n---\nM1: [ [1, 2], [3] ]\n")}),
              HasSubstr("bad.yml: M1 is no matrix; allowed: rows, cols, dt, and as many finite "));
  const char* torn = R"({"M1": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", )";
  EXPECT_THAT(Refusal({Write("torn.json", torn + std::string(R"("data": [1, 0]}})"))}),
              HasSubstr("torn.json: M1 is no matrix"));
  // The refusal names the line, and why OpenCV cannot read it.
  EXPECT_THAT(Refusal({Write("cut.yml", "%YAML:1.0\n---\nM1: !!opencv-matrix\n  data: [ 1, 2")}),
              HasSubstr("cut.yml: OpenCV cannot read it: (4): "));
  EXPECT_THAT(Refusal({folder_ / "nothing.yml"}), HasSubstr("nothing.yml: cannot be read"));
}

TEST_F(Import, RefusesMatricesThatAreNoRotation) {
  Truth scaled;
  scaled.r *= 1.5;
  Truth mirrored;
  for (int i = 0; i < 3; ++i) mirrored.r(i, 2) *= -1;
  for (const Truth& wrong : {scaled, mirrored}) {
    EXPECT_THAT(Refusal({WriteOpencv("r.yml", kNames, true, wrong)}),
                HasSubstr("r.yml: R is no rotation; allowed: a rotation matrix"));
  }
  Truth rounded;
  for (double& number : rounded.r.val) number = std::round(number * 1e4) / 1e4;
  EXPECT_NO_THROW(ReadForeignRig({WriteOpencv("rounded.yml", kNames, true, rounded)}));
}

TEST_F(Import, RefusesAnEntryOfOpencvsFilesThatIsThereTwice) {
  Truth other;
  other.t *= 2;
  const fs::path one = WriteOpencv("one.yml", kNames);
  EXPECT_THAT(Refusal({one, WriteOpencv("two.yml", kNames, true, other)}),
              HasSubstr("two.yml: T is there twice, and not the same; allowed: one of them"));
  ExpectTruth(ReadForeignRig({one, WriteOpencv("same.yml", kNames)}), truth_);
}

std::string List(const cv::Mat& numbers) {
  std::string text = "[";
  const cv::Mat1d row = numbers.reshape(1, 1);
  for (const double number : row) text += fmt::format("{:.17g}, ", number);
  return text.substr(0, text.size() - 2) + "]";
}

std::string RosYaml(const cv::Size& size, const std::string& name, const cv::Mat& k,
                    const std::vector<double>& d, const cv::Mat& r, const cv::Mat& p,
                    const std::string& model = "plumb_bob") {
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: {}\ndistortion_model: {}\n"
      "distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: {}\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: {}\n"
      "projection_matrix:\n  rows: 3\n  cols: 4\n  data: {}\n",
      size.width, size.height, name, List(k), model, d.size(), List(cv::Mat(d)), List(r), List(p));
}

TEST_F(Import, RefusesWhatOpencvWouldReadByEndlessRecursion) {
  constexpr int kDeep = 200'000;
  std::string tags;
  for (int i = 0; i < kDeep; ++i) tags += "<a>";
  const std::string list(kDeep, '[');
  for (const std::string& text :
       {"%YAML:1.0\n---\nb: !!opencv-matrix\na: " + list, "{\"a\": " + list,
        "<?xml version=\"1.0\"?>\n<opencv_storage>" + tags}) {
    EXPECT_THAT(Refusal({Write("deep.yml", text)}),
                HasSubstr("lists or elements within each other = 20000"));
  }
}

// The poses of both cameras are in R and P of their files alone.
TEST_F(Import, CameraInfoFilesOfRos) {
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(truth_.k1, truth_.d1, truth_.k2, truth_.d2, truth_.size, truth_.r, truth_.t, r1,
                    r2, p1, p2, q);
  // With a byte order mark in front, as Windows' editors leave it.
  const fs::path left =
      Write("left.yaml",
            "\xef\xbb\xbf" + RosYaml(truth_.size, "left", cv::Mat(truth_.k1), truth_.d1, r1, p1));
  const fs::path right =
      Write("right.yaml", RosYaml(truth_.size, "right", cv::Mat(truth_.k2), truth_.d2, r2, p2));
  const ForeignRig rig = ReadForeignRig({left, right});
  ExpectTruth(rig, truth_);
  EXPECT_EQ(rig.left.size, truth_.size);
  EXPECT_THAT(Refusal({left}), HasSubstr("left.yaml: the camera_info of one camera; allowed are "
                                         "two files, left and right"));
  EXPECT_THAT(Refusal({left, left}), HasSubstr("there is no baseline"));
  EXPECT_THAT(Refusal({left, Write("scaled.yaml", RosYaml(truth_.size, "right", cv::Mat(truth_.k2),
                                                          truth_.d2, 2 * r2, p2))}),
              HasSubstr("scaled.yaml: rectification_matrix is no rotation"));
  // The wrong way round the right camera stands on the left.
  EXPECT_LT(ReadForeignRig({right, left}).left_from_right.translation_m.x(), 0);
  EXPECT_THAT(Refusal({Write("none.yaml", "camera_matrix: 3\n"), right}),
              HasSubstr("none.yaml: no image_width and image_height"));
  EXPECT_THAT(Refusal({Write("other.yaml", "a: 3\n")}),
              HasSubstr("other.yaml: no calibration that is known; allowed are OpenCV's "));
  EXPECT_THAT(Refusal({Write("text.yaml", "a: [3\n")}), HasSubstr("text.yaml: no YAML: "));
  EXPECT_THAT(Refusal({Write("stereo.npz", std::string("PK\x03\x04\0\0", 6))}),
              HasSubstr("stereo.npz: no text, but binary, as of NumPy or Matlab"));
}

std::string KalibrCamera(const std::string& name, const cv::Matx33d& k, const std::string& model,
                         const std::vector<double>& d) {
  return fmt::format(
      "{}:\n  camera_model: pinhole\n  distortion_coeffs: [{}, {}, {}, {}]\n"
      "  distortion_model: {}\n  intrinsics: [{}, {}, {}, {}]\n  resolution: [640, 480]\n"
      "  rostopic: /{}/image_raw\n",
      name, d[0], d[1], d[2], d[3], model, k(0, 0), k(1, 1), k(0, 2), k(1, 2), name);
}

std::string KalibrPose(const cv::Matx33d& r, const cv::Vec3d& t) {
  std::string text = "  T_cn_cnm1:\n";
  for (int i = 0; i < 3; ++i) {
    text +=
        fmt::format("  - [{:.17g}, {:.17g}, {:.17g}, {:.17g}]\n", r(i, 0), r(i, 1), r(i, 2), t(i));
  }
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

TEST_F(Import, ACamchainOfKalibr) {
  Truth truth;
  truth.d1.resize(4);
  truth.d2.resize(4);
  const std::string first = KalibrCamera("cam0", truth.k1, "radtan", truth.d1);
  const std::string second = KalibrCamera("cam1", truth.k2, "radtan", truth.d2);
  ExpectTruth(
      ReadForeignRig({Write("camchain.yaml", first + second + KalibrPose(truth.r, truth.t))}),
      truth);
  // cam0 may be the right one.
  const cv::Matx33d back = truth.r.t();
  const ForeignRig swapped =
      ReadForeignRig({Write("swapped.yaml", KalibrCamera("cam0", truth.k2, "radtan", truth.d2) +
                                                KalibrCamera("cam1", truth.k1, "radtan", truth.d1) +
                                                KalibrPose(back, -(back * truth.t)))});
  ExpectTruth(swapped, truth);
  EXPECT_EQ(swapped.left.name, "cam1");
  EXPECT_THAT(Refusal({Write("one.yaml", first)}), HasSubstr("one.yaml: no cam1"));
  EXPECT_THAT(Refusal({Write("twice.yaml", first + second + KalibrPose(truth.r, truth.t) +
                                               "  intrinsics: [1, 1, 1, 1]\n")}),
              HasSubstr("twice.yaml: intrinsics is there twice; allowed: one of them"));
  EXPECT_THAT(Refusal({Write("bare.yaml", first + second)}),
              HasSubstr("no cam1: T_cn_cnm1 of 16 finite numbers"));
  EXPECT_THAT(Refusal({Write("omni.yaml", "cam0: {camera_model: omni}\ncam1:\n" +
                                              KalibrPose(truth.r, truth.t))}),
              HasSubstr("cam0 has camera_model 'omni'; allowed is pinhole"));
  EXPECT_THAT(Refusal({Write("scaled.yaml", first + second + KalibrPose(truth.r * 2, truth.t))}),
              HasSubstr("scaled.yaml: cam1: T_cn_cnm1 is no rotation"));
  EXPECT_THAT(Refusal({folder_ / "camchain.yaml", folder_ / "bare.yaml"}),
              HasSubstr("bare.yaml: a second file; allowed: a camchain alone"));
  EXPECT_THAT(Refusal({Write("model.yaml", KalibrCamera("cam0", truth.k1, "", truth.d1) + second +
                                               KalibrPose(truth.r, truth.t))}),
              HasSubstr("cam0 has distortion_model ''; allowed are radtan, equidistant and none"));
  const std::string plain =
      "{camera_model: pinhole, intrinsics: [500, 500, 320, 240], resolution: [640, 480]}\n";
  const ForeignRig bare = ReadForeignRig(
      {Write("plain.yaml", "cam0: " + plain + second + KalibrPose(truth.r, truth.t))});
  EXPECT_TRUE(bare.left.distortion.empty());
}

std::string Rows(const cv::Mat& matrix, const std::string& indent) {
  std::string text;
  for (int i = 0; i < matrix.rows; ++i) text += indent + "- " + List(matrix.row(i)) + "\n";
  return text;
}

// Poses of both cameras to a body, instead of one to the other. OpenVINS has OpenCV's line above.
TEST_F(Import, PosesToABody) {
  Truth truth;
  truth.d1.resize(4);
  truth.d2.resize(4);
  cv::Matx33d turn;
  cv::Rodrigues(cv::Vec3d(0.3, 1.5, -0.2), turn);
  cv::Mat1d left_from_body(cv::Matx44d::eye());
  cv::Mat(turn).copyTo(left_from_body(cv::Rect(0, 0, 3, 3)));
  left_from_body(0, 3) = 0.07;
  cv::Mat1d right_from_left(cv::Matx44d::eye());
  cv::Mat(truth.r).copyTo(right_from_left(cv::Rect(0, 0, 3, 3)));
  cv::Mat(truth.t).copyTo(right_from_left(cv::Rect(3, 0, 1, 3)));
  const std::array<cv::Mat, 2> from_body = {left_from_body, right_from_left * left_from_body};
  const std::array<std::string, 2> cameras = {KalibrCamera("cam0", truth.k1, "radtan", truth.d1),
                                              KalibrCamera("cam1", truth.k2, "radtan", truth.d2)};
  std::string to_cameras, to_body = "%YAML:1.0\n\n";
  std::vector<fs::path> euroc;
  for (size_t i : {0, 1}) {
    const cv::Mat body_from = from_body[i].inv();
    to_cameras += cameras[i] + "  T_cam_imu:\n" + Rows(from_body[i], "  ");
    to_body += cameras[i] + "  T_imu_cam:\n" + Rows(body_from, "  ");
    std::string text = cameras[i].substr(cameras[i].find('\n') + 1);
    text.replace(text.find("radtan"), 6, "radial-tangential");
    text.replace(text.find("_coeffs"), 7, "_coefficients");
    euroc.push_back(Write(
        i == 0 ? "cam0.yaml" : "cam1.yaml",
        text + "  T_BS:\n    cols: 4\n    rows: 4\n    data: " + List(body_from.clone()) + "\n"));
  }
  ExpectTruth(ReadForeignRig({Write("imucam.yaml", to_cameras)}), truth);
  ExpectTruth(ReadForeignRig({Write("openvins.yaml", to_body)}), truth);
  ExpectTruth(ReadForeignRig(euroc), truth);
  std::ranges::reverse(euroc);
  EXPECT_TRUE(ReadForeignRig(euroc).is_second_left);
  EXPECT_THAT(Refusal({euroc[0]}), HasSubstr("EuRoC's sensor.yaml of one camera; allowed are two"));
}

// yaml.dump() of the arrays' tolist(): each number in a line of its own.
TEST_F(Import, ListsOfPyYaml) {
  const auto block = [](const std::string& name, const cv::Mat1d& matrix) {
    std::string text = name + ":\n";
    for (int i = 0; i < static_cast<int>(matrix.total()); ++i) {
      text += fmt::format("{} - {:.17g}\n", i % matrix.cols == 0 ? "-" : " ", matrix(i));
    }
    return text;
  };
  ExpectTruth(
      ReadForeignRig({Write("stereo.yaml",
                            block("K1", cv::Mat(truth_.k1)) +
                                block("dist_left", cv::Mat(truth_.d1).reshape(1, 1)) +
                                block("K2", cv::Mat(truth_.k2)) +
                                block("dist_right", cv::Mat(truth_.d2).reshape(1, 1)) +
                                block("R", cv::Mat(truth_.r)) + block("T", cv::Mat(truth_.t)))}),
      truth_);
}

}  // namespace
}  // namespace sprout::calibrate
