#include "common/core/checks.h"
#include "common/messages/convert.h"
#include "common/messages/shortened.h"

namespace sprout {

process_info_t ToMessage(const ProcessInfo& info) {
  process_info_t message;
  message.header = ToMessage(info.header);
  message.stage = Shortened(info.stage, kMaxNameLength);
  message.host = Shortened(info.host, kMaxTextLength);
  message.version = Shortened(info.version, kMaxTextLength);
  message.config_digest = Shortened(info.config_digest, kMaxTextLength);
  message.config_text = Shortened(info.config_text, kMaxConfigLength);
  message.pid = info.pid;
  return message;
}

Result<ProcessInfo> FromMessage(const process_info_t& message) {
  Result<FrameId> header = FromMessage(message.header);
  if (!header) return tl::unexpected(header.error());
  Checks checks;
  checks.Length("stage", message.stage, kMaxNameLength)
      .Length("host", message.host, kMaxTextLength)
      .Length("version", message.version, kMaxTextLength)
      .Length("config_digest", message.config_digest, kMaxTextLength)
      .Length("config_text", message.config_text, kMaxConfigLength);
  if (!checks.ok()) return checks.error();
  return ProcessInfo{.header = *std::move(header),
                     .stage = message.stage,
                     .host = message.host,
                     .version = message.version,
                     .config_digest = message.config_digest,
                     .config_text = message.config_text,
                     .pid = message.pid};
}

}  // namespace sprout
