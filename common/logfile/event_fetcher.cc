#include "common/logfile/event_fetcher.h"

#include "common/logfile/event_format.h"

namespace sprout {
namespace {

constexpr int64_t kEventBytes = 4096;

}  // namespace

EventFetcher::EventFetcher(const std::filesystem::path& path)
    : file_(path), window_(file_, kEventBytes) {}

LogEvent EventFetcher::Fetch(int64_t offset) {
  const auto head = window_.View(offset, kMaxHeadBytes);
  const auto header = DecodeHeader(head);
  if (!header || !IsPlausible(*header, head) || header->event_bytes() > file_.size() - offset) {
    throw LogError(file_.path(), "changed while it was read");
  }
  return MakeEvent(*header, offset, window_.View(offset, header->event_bytes()));
}

}  // namespace sprout
