// ROS 2's messages in CDR, and MCAP files.

#include "common/ros/from_ros.h"
#include "common/ros/mcap_reader.h"
#include "common/ros/mcap_writer.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/ros/repacked.h"
#include "tests/common/ros/ros_examples.h"
#include "tests/fuzz/targets.h"

namespace sprout::fuzz {
namespace {

// Reads the bytes as T, and goes on with what it is.
template <typename T, typename Convert>
void ReadAs(std::span<const uint8_t> bytes, const Convert& convert) {
  const Result<RosMessage<T>> message = ReadCdr<T>(bytes);
  if (!message) return;
  Bytes again;
  WriteCdr(*message, again);
  Check(again.size() >= 4, "a message that was read cannot be written");
  convert(**message);
}

}  // namespace

void ReadRosMessage(std::span<const uint8_t> bytes) {
  Reader reader(bytes);
  const uint8_t type = reader.Byte();
  const std::span<const uint8_t> cdr = reader.rest();
  switch (type % 7) {
    case 0:
      return ReadAs<RosImage>(cdr, [](const RosImage& image) {
        (void)FromRosImage(image);
        (void)FromRosDepth(image);
        (void)FromRosStamp(image.header);
      });
    case 1:
      return ReadAs<RosCompressedImage>(cdr, [](const RosCompressedImage& image) {
        (void)FromRosImage(image, cv::Size(8, 8));
        (void)FromRosDepth(image, std::nullopt);
      });
    case 2:
      return ReadAs<RosCameraInfo>(cdr, [](const RosCameraInfo& info) {
        const Result<RosCamera> camera = FromRosInfo(info);
        if (camera) (void)PairOf(*camera, *camera);
      });
    case 3:
      return ReadAs<RosPointCloud>(cdr, [](const RosPointCloud& cloud) {
        const auto points = FromRosCloud(cloud);
        Check(!points || points->size() <= uint64_t{cloud.width} * cloud.height, "too many points");
      });
    case 4:
      return ReadAs<RosTransforms>(cdr, [](const RosTransforms& poses) {
        for (const RosTransform& one : RosSpan(poses.transforms)) (void)FromRosTransform(one);
      });
    case 5:
      return ReadAs<RosDisparity>(cdr, [](const RosDisparity&) {});
    default:
      return ReadAs<RosDiagnostics>(cdr, [](const RosDiagnostics&) {});
  }
}

std::vector<Bytes> RosSeeds() {
  std::vector<Bytes> seeds;
  const std::span types = RosTypes();
  examples::ForEachRosExample([&](const AnyRosMessage& message, const auto&) {
    // The order of the cases above.
    constexpr uint8_t kCases[] = {0, 1, 2, 3, 5, 4, 6};
    Bytes cdr;
    WriteCdr(message, cdr);
    for (size_t i = 0; i < types.size(); ++i) {
      if (types[i] == &message.type()) cdr.insert(cdr.begin(), kCases[i]);
    }
    seeds.push_back(std::move(cdr));
  });
  return seeds;
}

void ReadMcapFile(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  try {
    McapReader reader(file.path());
    for (McapMessage message; reader.Next(message);) {
      Check(message.data.size() <= kMaxMcapChunkBytes, "a message longer than any chunk");
    }
    Check(reader.position() <= reader.size(), "read behind the end");
  } catch (const ConfigError&) {
  }
}

std::vector<Bytes> McapSeeds() {
  std::vector<Bytes> seeds;
  const TemporaryDirectory folder;
  for (const char* compression : {"", "zstd", "lz4"}) {
    McapWriter writer(folder / "seed", {.profile = "ros2", .library = "", .chunk_bytes = 200});
    const uint16_t schema = writer.AddSchema("std_msgs/msg/String", "ros2msg", "string data\n");
    const uint16_t channel = writer.AddChannel(schema, "/topic", "cdr");
    for (uint32_t i = 0; i < 6; ++i) writer.Write(channel, i, i, Bytes(20 * i, uint8_t{7}));
    writer.AddMetadata("name", {{"key", "value"}});
    Check(writer.Commit().has_value(), "no seed");
    seeds.push_back(Repacked(ReadBytes(folder / "seed"), compression));
  }
  return seeds;
}

}  // namespace sprout::fuzz
