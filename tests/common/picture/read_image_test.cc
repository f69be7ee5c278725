#include "common/picture/read_image.h"

#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "common/config/required.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

class ReadImageFile : public testing::Test {
 protected:
  std::string File(const std::string& name) const { return folder_ / name.c_str(); }

  // Of 13×9 px, written by OpenCV.
  std::string Write(const std::string& name, int type, const std::vector<int>& flags = {}) const {
    cv::Mat image(9, 13, type);
    cv::randu(image, 0, 256);
    EXPECT_TRUE(cv::imwrite(File(name), image, flags));
    return File(name);
  }

  // Changes bytes of a file, in place.
  static void Patch(const std::string& file, int64_t offset, const std::string& bytes) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(offset);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }

  static int64_t Find(const std::string& file, const std::string& what) {
    return static_cast<int64_t>(FileText(file).find(what));
  }

  static std::string ErrorOf(const std::string& file) {
    const auto image = DecodeImageFile(file, cv::IMREAD_UNCHANGED, kCameraFormats);
    return image ? "no error" : image.error().text;
  }

  const TemporaryDirectory folder_;
};

TEST_F(ReadImageFile, DecodesEveryFormatAsOpenCvDoes) {
  const std::string files[] = {
      Write("a.png", CV_8UC1),
      Write("b.png", CV_16UC1),
      Write("c.png", CV_8UC3),
      Write("d.jpg", CV_8UC3),
      Write("e.jpg", CV_8UC1, {cv::IMWRITE_JPEG_PROGRESSIVE, 1, cv::IMWRITE_JPEG_RST_INTERVAL, 2}),
      Write("f.pgm", CV_8UC1),
      Write("g.ppm", CV_8UC3),
      Write("h.ppm", CV_8UC3, {cv::IMWRITE_PXM_BINARY, 0}),
      Write("i.bmp", CV_8UC3),
      Write("j.tiff", CV_32FC1),
      Write("k.tiff", CV_16UC1)};
  for (const std::string& file : files) {
    const auto image = Required(DecodeImageFile(file, cv::IMREAD_UNCHANGED, kCameraFormats));
    const cv::Mat expected = cv::imread(file, cv::IMREAD_UNCHANGED);
    ASSERT_EQ(image.type(), expected.type()) << file;
    EXPECT_EQ(cv::norm(image, expected, cv::NORM_INF), 0) << file;
  }
}

TEST_F(ReadImageFile, TakesCommentsInAPgmHeader) {
  std::ofstream(File("a.pgm"), std::ios::binary) << "P5\n# by 99 hands\n2 # wide\n1\n255\nab";
  const auto image =
      Required(DecodeImageFile(File("a.pgm"), cv::IMREAD_UNCHANGED, kPictureFormats));
  EXPECT_EQ(image.size(), cv::Size(2, 1));
}

// Headers that claim 65500×65500 px; their files are small.
TEST_F(ReadImageFile, RefusesLargeImagesByTheirHeaderAlone) {
  using namespace std::string_literals;
  const std::string png = Write("a.png", CV_8UC1);
  Patch(png, 16, "\x00\x00\xff\xdc\x00\x00\xff\xdc"s);
  const std::string jpeg = Write("b.jpg", CV_8UC3);
  Patch(jpeg, Find(jpeg, "\xff\xc0"s) + 5, "\xff\xdc\xff\xdc"s);
  const std::string pgm = File("c.pgm");
  std::ofstream(pgm) << "P5\n65500 65500\n255\nabc";
  const std::string bmp = Write("d.bmp", CV_8UC3);
  Patch(bmp, 18, "\xdc\xff\x00\x00\xdc\xff\x00\x00"s);
  for (const std::string& file : {png, jpeg, pgm, bmp}) {
    EXPECT_THAT(ErrorOf(file),
                ::testing::AllOf(HasSubstr("image " + file + ": 65500x65500 px"),
                                 HasSubstr("allowed: 1 to 16384 px a side and 100000000 pixels")));
  }
  // From the top to the bottom: its height is negative.
  Patch(bmp, 22, "\x24\x00\xff\xff"s);
  EXPECT_THAT(ErrorOf(bmp), HasSubstr("65500x65500 px"));
  const std::string many = File("e.pgm");
  std::ofstream(many) << "P5\n16384 16384\n255\n";
  EXPECT_THAT(ErrorOf(many), HasSubstr("16384x16384 px"));
}

TEST_F(ReadImageFile, RefusesALargeTiffByItsDirectory) {
  using namespace std::string_literals;
  const std::string tiff = File("a.tiff");
  std::ofstream(tiff, std::ios::binary)
      << "MM\0*\0\0\0\x08\0\x02"s                 // big-endian; two entries
      << "\x01\0\0\x04\0\0\0\x01\0\0\xff\xdc"s    // width, a long
      << "\x01\x01\0\x03\0\0\0\x01\xff\xdc\0\0"s  // height, a short
      << "\0\0\0\0"s;
  EXPECT_THAT(ErrorOf(tiff), HasSubstr("65500x65500 px"));
}

TEST_F(ReadImageFile, RefusesATiffOfSeveralPages) {
  const std::string pages = File("pages.tiff");
  const std::vector<cv::Mat> two(2, cv::Mat1b(3, 4, uint8_t{7}));
  ASSERT_TRUE(cv::imwritemulti(pages, two));
  EXPECT_THAT(ErrorOf(pages), HasSubstr("has several pages"));
  ASSERT_TRUE(cv::imwritemulti(pages, std::vector<cv::Mat>(1, two[0])));
  EXPECT_EQ(ErrorOf(pages), "no error");
}

// What is missing would be filled, and the image be taken for whole.
TEST_F(ReadImageFile, RefusesAJpegThatIsCut) {
  using namespace std::string_literals;
  const std::string files[] = {Write("a.jpg", CV_8UC3),
                               Write("b.jpg", CV_8UC1, {cv::IMWRITE_JPEG_RST_INTERVAL, 1}),
                               Write("c.jpg", CV_8UC3, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})};
  for (const std::string& file : files) {
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 2);
    const std::string error = "image " + file + ": ends early";
    EXPECT_THAT(ErrorOf(file), HasSubstr(error));
    std::filesystem::resize_file(file, std::filesystem::file_size(file) + 500);  // by zeros
    EXPECT_THAT(ErrorOf(file), HasSubstr(error));
  }
}

TEST_F(ReadImageFile, IsSoonDoneWithAJpegOfFillBytes) {
  using Clock = std::chrono::steady_clock;
  std::ofstream(File("a.jpg"), std::ios::binary) << "\xff\xd8" << std::string(4'000'000, '\xff');
  const auto begin = Clock::now();
  EXPECT_NE(ErrorOf(File("a.jpg")), "no error");
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));  // 20 and more if each were looked for
}

TEST_F(ReadImageFile, FindsTheEndOfAJpegBehindAThumbnailAndBeforeOtherBytes) {
  using namespace std::string_literals;
  const std::string file = Write("a.jpg", CV_8UC3);
  std::ofstream(file, std::ios::binary | std::ios::app) << "a camera's own data \xff\xe1";
  EXPECT_EQ(ErrorOf(file), "no error");
  // The same with a segment that holds an end of its own, whole and cut.
  const std::string bytes = FileText(file);
  const std::string with_thumbnail = "\xff\xd8\xff\xe1\x00\x06\xff\xd8\xff\xd9"s + bytes.substr(2);
  std::ofstream(File("b.jpg"), std::ios::binary) << with_thumbnail;
  EXPECT_EQ(ErrorOf(File("b.jpg")), "no error");
  std::filesystem::resize_file(File("b.jpg"), bytes.size() - 40);
  EXPECT_THAT(ErrorOf(File("b.jpg")), HasSubstr("ends early"));
}

TEST_F(ReadImageFile, NamesWhatCannotBeDecoded) {
  const char* const reason =
      "cannot be decoded; allowed: a readable PNG, JPEG, PPM, BMP or TIFF file";
  const char* const missing =
      "none.png: is missing; allowed: a readable PNG, JPEG, PPM, BMP or TIFF";
  EXPECT_THAT(ErrorOf(File("none.png")), HasSubstr(missing));
  std::filesystem::create_symlink(File("nowhere.png"), File("link_to_none.png"));
  EXPECT_THAT(ErrorOf(File("link_to_none.png")), HasSubstr(missing));
  EXPECT_THAT(ErrorOf(folder_ / ""), HasSubstr(reason));
  std::ofstream(File("text.png")) << "text";
  EXPECT_THAT(ErrorOf(File("text.png")), HasSubstr(reason));
  std::ofstream(File("a.npy"), std::ios::binary) << "\x93NUMPY\x01";
  EXPECT_THAT(ErrorOf(File("a.npy")), HasSubstr("cannot be decoded (a NumPy array; cv2.imwrite"));
  std::ofstream(File("a.png")) << "version https://git-lfs.github.com/spec/v1\n";
  EXPECT_THAT(ErrorOf(File("a.png")), HasSubstr("(a pointer of Git LFS; git lfs pull gets"));
  const std::string cut = Write("cut.png", CV_8UC1);
  std::filesystem::resize_file(cut, 30);
  EXPECT_THAT(ErrorOf(cut), HasSubstr(reason));
  const std::string no_frame = File("no_frame.jpg");
  std::ofstream(no_frame, std::ios::binary) << "\xff\xd8\xff\xd9";
  EXPECT_THAT(ErrorOf(no_frame), HasSubstr(reason));
  EXPECT_THAT(
      WhyNot(DecodeImageFile(Write("a.tiff", CV_8UC1), cv::IMREAD_UNCHANGED, kPictureFormats)),
      HasSubstr("allowed: a readable PNG, JPEG or PPM file"));
}

}  // namespace
}  // namespace sprout
