#pragma once

#include "tests/fuzz/target.h"

namespace sprout::fuzz {

// messages.cc
void DecodeMessage(std::span<const uint8_t> bytes);
std::vector<Bytes> MessageSeeds();
void JoinMessages(std::span<const uint8_t> bytes);
std::vector<Bytes> FrameSeeds();

// log.cc
void ReadWholeLog(std::span<const uint8_t> bytes);
std::vector<Bytes> LogSeeds();

// ros2.cc
void ReadRosMessage(std::span<const uint8_t> bytes);
std::vector<Bytes> RosSeeds();
void ReadMcapFile(std::span<const uint8_t> bytes);
std::vector<Bytes> McapSeeds();

// settings.cc
void ReadConfig(std::span<const uint8_t> bytes);
std::vector<Bytes> ConfigSeeds();
void ReadRig(std::span<const uint8_t> bytes);
std::vector<Bytes> RigSeeds();

// datasets.cc
void ReadMiddleburyCalibration(std::span<const uint8_t> bytes);
std::vector<Bytes> MiddleburySeeds();
void ReadKitti(std::span<const uint8_t> bytes);
std::vector<Bytes> KittiSeeds();
void ReadScan(std::span<const uint8_t> bytes);
std::vector<Bytes> ScanSeeds();

// images.cc
void ReadPfmFile(std::span<const uint8_t> bytes);
std::vector<Bytes> PfmSeeds();
void ReadImageFile(std::span<const uint8_t> bytes);
std::vector<Bytes> ImageSeeds();
void ReadPayload(std::span<const uint8_t> bytes);
std::vector<Bytes> PayloadSeeds();

// page.cc
void AnswerHttp(std::span<const uint8_t> bytes);
std::vector<Bytes> HttpSeeds();
void AnswerPage(std::span<const uint8_t> bytes);
std::vector<Bytes> PageSeeds();

}  // namespace sprout::fuzz
