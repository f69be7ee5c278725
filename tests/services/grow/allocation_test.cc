// Growth and gap filling must not allocate once they have seen a frame. This program counts what
// malloc's users ask for, so it is one of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "services/grow/gap_filler.h"
#include "services/grow/grower.h"

namespace {

std::atomic<int64_t> allocations{0};

// OpenCV's own allocator, counted.
class CountingAllocator : public cv::MatAllocator {
 public:
  cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                         cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    if (data == nullptr) ++allocations;
    cv::UMatData* memory = standard_->allocate(dims, sizes, type, data, step, flags, usage);
    memory->currAllocator = memory->prevAllocator = standard_;
    return memory;
  }
  bool allocate(cv::UMatData* data, cv::AccessFlag access,
                cv::UMatUsageFlags usage) const override {
    return standard_->allocate(data, access, usage);
  }
  void deallocate(cv::UMatData* data) const override { standard_->deallocate(data); }

 private:
  cv::MatAllocator* standard_ = cv::Mat::getStdAllocator();
};

}  // namespace

// Not inlined, or GCC takes malloc and free for a mismatch of new and delete.
[[gnu::noinline]] void* operator new(size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace sprout {
namespace {

struct Input {
  explicit Input(cv::Size size, uint32_t seed) : left(size), right(size), prior(size) {
    std::mt19937 random(seed);
    for (uint8_t& value : left) value = static_cast<uint8_t>(random());
    right = 0;
    left.colRange(5, size.width).copyTo(right.colRange(0, size.width - 5));
    prior.counts() = ToCounts(5);
    for (int i = 0; i < 200; ++i) {
      const auto u = static_cast<float>(random() % static_cast<uint32_t>(size.width));
      const auto v = static_cast<float>(random() % static_cast<uint32_t>(size.height));
      seeds.push_back({u, v, u - 5});
    }
  }

  cv::Mat1b left;
  cv::Mat1b right;
  std::vector<Seed> seeds;
  DisparityImage prior;
};

TEST(Allocation, GuardSeesNewAndOpenCv) {
  CountingAllocator counting;
  cv::Mat::setDefaultAllocator(&counting);
  const int64_t before = allocations;
  { const cv::Mat1b image(10, 10); }
  EXPECT_GT(allocations, before);
  cv::Mat::setDefaultAllocator(cv::Mat::getStdAllocator());
  const int64_t then = allocations;
  { const std::vector<int> values(10); }
  EXPECT_GT(allocations, then);
}

TEST(Allocation, GrowthAndFillingAllocateNothingInSteadyState) {
  cv::setNumThreads(1);  // handing work to other threads is OpenCV's business
  const Input first({200, 150}, 1);
  const Input second({200, 150}, 2);
  for (const auto similarity : {GrowConfig::EPC, GrowConfig::EXPSSD, GrowConfig::MNCC}) {
    GrowConfig config;
    config.set_similarity(similarity);
    Grower grower(config);
    GapFiller filler;
    int64_t valid = 0;
    const auto run = [&](const Input& input) {
      const auto map = grower.Compute(input.left, input.right, input.seeds, input.prior);
      for (const auto fill : {GrowConfig::ONE_PASS, GrowConfig::UNTIL_STABLE, GrowConfig::PRIOR}) {
        const DisparityImage filled = filler.Fill(*map, fill, input.prior);
        valid += cv::countNonZero(filled.counts());
      }
    };
    run(first);
    run(second);
    CountingAllocator counting;
    cv::Mat::setDefaultAllocator(&counting);
    const int64_t before = allocations;
    run(first);
    run(second);
    EXPECT_EQ(allocations - before, 0) << GrowConfig::Similarity_Name(similarity);
    cv::Mat::setDefaultAllocator(cv::Mat::getStdAllocator());
    EXPECT_GT(valid, 0);
  }
}

}  // namespace
}  // namespace sprout
