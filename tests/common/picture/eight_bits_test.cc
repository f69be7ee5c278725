#include "common/picture/eight_bits.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

CameraImage Image(const cv::Mat& pixels, int largest = 0) { return {pixels.clone(), largest}; }

// A ramp from `low` to `high`, 16 bits.
cv::Mat1w Ramp(int low, int high) {
  cv::Mat1w ramp(20, 50);
  for (int i = 0; i < 1000; ++i) {
    ramp(i / 50, i % 50) = static_cast<uint16_t>(low + (high - low) * i / 999);
  }
  return ramp;
}

TEST(EightBits, LeavesImagesOf8BitsAsTheyAre) {
  CameraImage image = Image(cv::Mat1b(2, 2, uint8_t{200}));
  EightBits eight_bits;
  eight_bits.Convert({&image});
  EXPECT_EQ(image.pixels.at<uint8_t>(0, 0), 200);
  EXPECT_THAT(eight_bits.TakeNote(), IsEmpty());
}

TEST(EightBits, SayOnceThatBitsOf8BitImagesChangeNothing) {
  for (const int bits : {8, 12}) {
    EightBits eight_bits(bits);
    CameraImage image = Image(cv::Mat1b(2, 2, uint8_t{200}));
    eight_bits.Convert({&image});
    EXPECT_EQ(image.pixels.at<uint8_t>(0, 0), 200);
    EXPECT_EQ(eight_bits.TakeNote(),
              bits == 8 ? "" : "bits = 12 changes nothing: images of 8 bits are taken as they are");
    eight_bits.Convert({&image});
    EXPECT_THAT(eight_bits.TakeNote(), IsEmpty());
  }
}

TEST(EightBits, SayThatBytesSeemToBeInTheOtherOrder) {
  const auto note_of = [](const cv::Mat1w& pixels, int largest = 0) {
    CameraImage image{pixels.clone(), largest};
    EightBits eight_bits;
    eight_bits.Convert({&image});
    return eight_bits.TakeNote();
  };
  for (const int bits : {10, 12, 14}) {
    const int most = (1 << bits) - 1;
    cv::Mat1w ramp = Ramp(0, most);
    EXPECT_THAT(note_of(ramp), testing::Not(HasSubstr("other order"))) << bits;
    EXPECT_THAT(note_of(ramp, most), IsEmpty());
    for (uint16_t& pixel : ramp) pixel = static_cast<uint16_t>(pixel << 8 | pixel >> 8);
    EXPECT_THAT(note_of(ramp), HasSubstr("are the bytes in the other order?")) << bits;
    EXPECT_THAT(note_of(ramp, most), HasSubstr("are the bytes in the other order?")) << bits;
    for (uint16_t& pixel : ramp) pixel = static_cast<uint16_t>(pixel & 0xff00);  // 8 bits shifted
    EXPECT_THAT(note_of(ramp), testing::Not(HasSubstr("other order")));
  }
}

TEST(EightBits, SayOnceThatPixelsAreBeyondTheBitsThatWereAskedFor) {
  EightBits eight_bits(12);
  CameraImage within = Image(Ramp(0, 4095));
  eight_bits.Convert({&within});
  EXPECT_THAT(eight_bits.TakeNote(), IsEmpty());
  for (const bool is_first : {true, false}) {
    CameraImage shifted = Image(Ramp(0, 4095) * 16);  // left-aligned in 16
    eight_bits.Convert({&shifted});
    const std::string note = eight_bits.TakeNote();
    EXPECT_EQ(note.empty(), !is_first) << note;
    if (is_first) {
      EXPECT_THAT(note, HasSubstr("bits = 12: 93.7 % of the pixels are above 4095"));
    }
  }
}

TEST(EightBits, SaysWhichBitsCanBeAskedFor) {
  for (const int bits : {0, 8, 16}) EXPECT_TRUE(CheckBits(bits)) << bits;
  for (const int bits : {-8, 1, 7, 17}) {
    EXPECT_EQ(WhyNot(CheckBits(bits)), std::to_string(bits) + ": allowed: 8 to 16, or 0");
  }
}

TEST(EightBits, TakesTheBitsThatThePixelsUse) {
  for (const auto& [most, bits] :
       {std::pair{255, 8}, {1023, 10}, {900, 10}, {4095, 12}, {16383, 14}, {65535, 16}}) {
    CameraImage image = Image(Ramp(0, most));
    EightBits eight_bits;
    eight_bits.Convert({&image});
    ASSERT_EQ(image.pixels.type(), CV_8UC1);
    EXPECT_EQ(image.pixels.at<uint8_t>(19, 49), most >> (bits - 8)) << most;
    EXPECT_EQ(image.pixels.at<uint8_t>(10, 0), (most * 500 / 999) >> (bits - 8)) << most;
  }
}

TEST(EightBits, TakesLeftAndRightTheSameWay) {
  CameraImage left = Image(Ramp(0, 1000));
  CameraImage right = Image(Ramp(0, 1040));
  EightBits().Convert({&left, &right});
  EXPECT_EQ(left.pixels.at<uint8_t>(19, 49), 1000 >> 4);
  EXPECT_EQ(right.pixels.at<uint8_t>(19, 49), 1040 >> 4);
}

TEST(EightBits, AreTheSameForAWholeRecording) {
  EightBits eight_bits;
  CameraImage bright = Image(Ramp(0, 4000));
  eight_bits.Convert({&bright});
  EXPECT_THAT(eight_bits.TakeNote(), HasSubstr("use 0 to 4095"));
  CameraImage dark = Image(Ramp(0, 500));
  eight_bits.Convert({&dark});
  EXPECT_EQ(dark.pixels.at<uint8_t>(19, 49), 500 >> 4);
  EXPECT_THAT(eight_bits.TakeNote(), IsEmpty());
  CameraImage brighter = Image(Ramp(0, 5000));
  eight_bits.Convert({&brighter});
  EXPECT_EQ(brighter.pixels.at<uint8_t>(19, 49), 5000 >> 6);
  EXPECT_THAT(eight_bits.TakeNote(), HasSubstr("brightness changes: "));
}

TEST(EightBits, TakeTheBandOfAThermalCamera) {
  EightBits eight_bits;
  CameraImage image = Image(Ramp(7000, 7799));
  eight_bits.Convert({&image});
  // Twice as wide as what is used, which takes the middle half.
  EXPECT_NEAR(image.pixels.at<uint8_t>(0, 0), 64, 2);
  EXPECT_NEAR(image.pixels.at<uint8_t>(19, 49), 191, 2);
  CameraImage warmer = Image(Ramp(7300, 8000));
  eight_bits.Convert({&warmer});
  EXPECT_NEAR(warmer.pixels.at<uint8_t>(19, 49), 223, 2);
}

TEST(EightBits, AreWhatTheUserOrTheFormatSays) {
  CameraImage image = Image(Ramp(0, 900), 4095);
  EightBits().Convert({&image});
  EXPECT_EQ(image.pixels.at<uint8_t>(19, 49), 900 >> 4);
  CameraImage other = Image(Ramp(0, 900), 4095);
  EightBits(16).Convert({&other});
  EXPECT_EQ(other.pixels.at<uint8_t>(19, 49), 900 >> 8);
}

TEST(EightBits, ReadThePgmsLargestValue) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "a.pgm", std::ios::binary) << "P5\n# 12 bits\n2 1\n4095\n"
                                                    << std::string("\x0f\xff\x08\x00", 4);
  std::ofstream(folder / "b.pgm", std::ios::binary) << "P5 2 1 100\n" << std::string("\x64\x32", 2);
  auto twelve = ReadCameraImage(folder / "a.pgm").value();
  EXPECT_EQ(twelve.largest, 4095);
  EightBits().Convert({&twelve});
  EXPECT_EQ(twelve.pixels.at<uint8_t>(0, 0), 255);
  EXPECT_EQ(twelve.pixels.at<uint8_t>(0, 1), 128);
  auto hundred = ReadCameraImage(folder / "b.pgm").value();
  EightBits().Convert({&hundred});
  EXPECT_EQ(hundred.pixels.at<uint8_t>(0, 0), 255);
  EXPECT_NEAR(hundred.pixels.at<uint8_t>(0, 1), 128, 1);
}

TEST(ReadCameraImage, RefusesFloatingPoint) {
  const TemporaryDirectory folder;
  ASSERT_TRUE(cv::imwrite(folder / "a.tiff", cv::Mat1f(3, 3, 1.0F)));
  EXPECT_THAT(WhyNot(ReadCameraImage(folder / "a.tiff")),
              HasSubstr("CV_32FC1; allowed: grey or colour with 8 or 16 bits"));
}

}  // namespace
}  // namespace sprout
