#pragma once

#include <gtest/gtest.h>

#include "tests/common/picture/temporary_directory.h"

namespace sprout {

/// A test with a folder of its own.
class TestWithFolder : public ::testing::Test {
 protected:
  const TemporaryDirectory folder_;
};

}  // namespace sprout
