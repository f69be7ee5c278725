#include "services/tools/calibrate/board.h"

#include <gtest/gtest.h>

#include "common/config/config_error.h"

namespace sprout::calibrate {
namespace {

TEST(Board, HasACornerWhereFourSquaresMeet) {
  const Board board({.columns = 6, .rows = 4, .square_m = 0.05});
  const cv::Mat1b modules = board.Modules();

  ASSERT_EQ(modules.size(), cv::Size(48, 32));
  ASSERT_EQ(board.corner_count(), 5 * 3);
  for (int id = 0; id < board.corner_count(); ++id) {
    const Eigen::Vector3d modules_from_edge = board.corner(id) / 0.05 * 8;
    const int x = static_cast<int>(std::lround(modules_from_edge.x()));
    const int y = static_cast<int>(std::lround(modules_from_edge.y()));
    EXPECT_EQ(modules(y, x), modules(y - 1, x - 1)) << id;
    EXPECT_EQ(modules(y - 1, x), modules(y, x - 1)) << id;
    EXPECT_NE(modules(y, x), modules(y - 1, x)) << id;
  }
}

TEST(Board, RefusesWhatCannotBePrintedOrFound) {
  EXPECT_THROW(Board({.columns = 2, .rows = 6, .square_m = 0.05}), ConfigError);
  EXPECT_THROW(Board({.columns = 2'000'000'000, .rows = 2'000'000'000, .square_m = 0.05}),
               ConfigError);
  EXPECT_THROW(Board({.columns = 9, .rows = 6, .square_m = 0}), ConfigError);
  EXPECT_THROW(Board({.columns = 9, .rows = 6, .square_m = std::nan("")}), ConfigError);
}

}  // namespace
}  // namespace sprout::calibrate
