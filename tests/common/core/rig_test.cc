#include "common/core/rig.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <locale>
#include <set>
#include <stdexcept>

#include "common/core/digest.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

// A program that has set the user's locale, where commas are decimal and dots are not; while it
// lives. The locale is made where it stands, from what Debian's package locales brings.
class GermanLocale {
 public:
  GermanLocale() {
    const std::string folder = (folder_ / "de_DE.UTF-8").string();
    const std::string make = "localedef -i de_DE -f UTF-8 '" + folder + "' 2>&1";
    if (std::system(make.c_str()) != 0) return;
    setenv("LOCPATH", (folder_ / "").c_str(), 1);
    try {
      std::locale::global(std::locale("de_DE.UTF-8"));  // C's, too
      is_set_ = true;
    } catch (const std::runtime_error&) {
    }
  }
  ~GermanLocale() {
    std::locale::global(std::locale::classic());
    unsetenv("LOCPATH");
  }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;

  bool is_set() const { return is_set_; }

 private:
  TemporaryDirectory folder_;
  bool is_set_ = false;
};

Rig ExampleRig() {
  Rig rig;
  rig.pair = {.width = 640,
              .height = 480,
              .focal_px = 500,
              .cx = 320.5,
              .cy = 240.25,
              .cx_right = 310.75,
              .baseline_m = 0.125};
  rig.tof = {.width = 176,
             .height = 144,
             .fx = 220,
             .fy = 221,
             .cx = 88,
             .cy = 72,
             .distortion = {-0.25, 0.125, 0.001, -0.002, 0.5},
             .left_from_tof_rotation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5),
             .left_from_tof_translation_m = {0.0625, -0.03125, 0.25}};
  return rig;
}

TEST(Digest, IsXxh3InHexadecimalDigits) {
  EXPECT_EQ(Digest(""), "2d06800538d394c2");  // XXH3_64bits of nothing, from its specification
  EXPECT_EQ(Digest("sprout").size(), 16U);
  EXPECT_NE(Digest("sprout"), Digest("Sprout"));
}

TEST(RigId, IsStable) {
  EXPECT_EQ(RigId(ExampleRig()), RigId(ExampleRig()));
  // Logs name calibrations by it: it may not change between versions or machines.
  EXPECT_EQ(RigId(ExampleRig()), "e26841a5b531426a");
}

// A program with a window sets the user's locale before it calls us.
TEST(RigId, IsTheSameWhereCommasAreDecimal) {
  const GermanLocale german;
  if (!german.is_set()) GTEST_SKIP() << "no German locale can be made (package locales)";
  ASSERT_EQ(std::to_string(1.5), "1,500000");
  EXPECT_EQ(RigId(ExampleRig()), "e26841a5b531426a");
}

TEST(RigId, DiffersWhenAnyNumberChanges) {
  const std::vector<std::function<void(Rig&)>> changes = {
      [](Rig& rig) { ++rig.pair.width; },
      [](Rig& rig) { ++rig.pair.height; },
      [](Rig& rig) { rig.pair.focal_px += 1e-9; },
      [](Rig& rig) { rig.pair.cx += 1e-9; },
      [](Rig& rig) { rig.pair.cy += 1e-9; },
      [](Rig& rig) { rig.pair.cx_right += 1e-9; },
      [](Rig& rig) { rig.pair.baseline_m += 1e-9; },
      [](Rig& rig) { ++rig.tof.width; },
      [](Rig& rig) { ++rig.tof.height; },
      [](Rig& rig) { rig.tof.fx += 1e-9; },
      [](Rig& rig) { rig.tof.fy += 1e-9; },
      [](Rig& rig) { rig.tof.cx += 1e-9; },
      [](Rig& rig) { rig.tof.cy += 1e-9; },
      [](Rig& rig) { rig.tof.distortion[0] += 1e-9; },
      [](Rig& rig) { rig.tof.distortion[1] += 1e-9; },
      [](Rig& rig) { rig.tof.distortion[2] += 1e-9; },
      [](Rig& rig) { rig.tof.distortion[3] += 1e-9; },
      [](Rig& rig) { rig.tof.distortion[4] += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_rotation.w() += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_rotation.x() += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_rotation.y() += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_rotation.z() += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_translation_m.x() += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_translation_m.y() += 1e-9; },
      [](Rig& rig) { rig.tof.left_from_tof_translation_m.z() += 1e-9; },
      [](Rig& rig) { std::swap(rig.tof.cx, rig.tof.cy); },
  };
  std::set<std::string> ids = {RigId(ExampleRig())};
  for (size_t i = 0; i < changes.size(); ++i) {
    Rig rig = ExampleRig();
    changes[i](rig);
    EXPECT_TRUE(ids.insert(RigId(rig)).second) << "change " << i << " leaves the id as it was";
  }
}

TEST(RigId, IsEqualForEqualNumbers) {
  Rig rig = ExampleRig();
  Rig negative_zero = ExampleRig();
  rig.tof.distortion[4] = 0.0;
  negative_zero.tof.distortion[4] = -0.0;
  EXPECT_EQ(RigId(rig), RigId(negative_zero));
}

}  // namespace
}  // namespace sprout
