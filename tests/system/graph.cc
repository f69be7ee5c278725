#include "tests/system/graph.h"

#include <stdexcept>

#include "common/messages/codec.h"

namespace sprout {

Graph::Graph(std::string prefix, std::string url, const std::vector<std::string_view>& channels)
    : prefix_(std::move(prefix)),
      url_(std::move(url)),
      publisher_(url_, prefix_),
      receiver_(url_, prefix_, channels,
                [this](std::string_view channel, std::span<const uint8_t> bytes) {
                  OnMessage(channel, bytes);
                }) {}

void Graph::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  if (channel == kStatusChannel) {
    if (const Result<StageStatus> status = DecodeStatus(bytes)) statuses[status->stage] = *status;
  }
  if (const std::optional<Part> part = PartOf(channel)) {
    Result<DecodedPart> decoded = DecodePart(*part, bytes);
    if (decoded) {  // tests send bad ones, too
      parts[{*part, decoded->id.seq}] = std::move(decoded->value);
      ++part_counts[{*part, decoded->id.seq}];
    }
  }
  changed_.notify_all();
}

Process& Graph::StartOnly(const std::string& stage, std::vector<std::string> flags) {
  std::vector<std::string> command = {ProgramPath("sprout-" + stage), "--lcm-url", url_};
  if (!prefix_.empty()) command.insert(command.end(), {"--channel-prefix", prefix_});
  command.insert(command.end(), flags.begin(), flags.end());
  auto& process = processes_[stage];
  process = std::make_unique<Process>(command);
  return *process;
}

Process& Graph::Start(const std::string& stage, std::vector<std::string> flags) {
  {
    const std::lock_guard lock(mutex_);
    statuses.erase(stage);
  }
  Process& process = StartOnly(stage, std::move(flags));
  if (!WaitUntil([&](Graph& graph) { return graph.statuses.contains(stage); })) {
    throw std::runtime_error("no status from " + stage + ":\n" + process.Output());
  }
  return process;
}

void Graph::StartChain(const std::vector<std::string>& flags) {
  for (const char* stage : kChain) Start(stage, flags);
}

void Graph::Capture(std::vector<std::string> flags, std::chrono::seconds timeout) {
  std::string stages;
  for (const auto& [stage, process] : processes_) stages += (stages.empty() ? "" : ",") + stage;
  flags.insert(flags.end(), {"--lockstep", "1", "--wait-for", stages});
  Process& capture = StartOnly("capture", flags);
  if (capture.Wait(timeout) != 0) throw std::runtime_error("capture failed:\n" + capture.Output());
}

bool Graph::WaitUntil(const std::function<bool(Graph&)>& condition, std::chrono::seconds timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] { return condition(*this); });
}

void Graph::Look(const std::function<void(Graph&)>& look) {
  const std::lock_guard lock(mutex_);
  look(*this);
}

void Graph::Publish(std::string_view channel, std::span<const uint8_t> bytes) {
  if (!publisher_.Publish(channel, bytes)) throw std::runtime_error("publish failed");
}

void Graph::PublishPart(const FrameId& id, Part part, const PartValue& value) {
  Publish(ChannelOf(part), EncodePart(id, part, value));
}

void Graph::PublishFrame(int64_t utime, int64_t seq, const Rig& rig, const cv::Mat& left,
                         const cv::Mat& right, const TofImage& tof) {
  const FrameId id{.utime = utime, .seq = seq, .rig_id = RigId(rig)};
  PublishPart(id, Part::kRig, rig);
  PublishPart(id, Part::kLeft, left);
  PublishPart(id, Part::kRight, right);
  PublishPart(id, Part::kTof, tof);
}

}  // namespace sprout
