#include "common/core/digest.h"

#include <xxhash.h>

#include <cinttypes>
#include <cstdio>

namespace sprout {
namespace {

std::string AsText(uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

}  // namespace

uint64_t Hash(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string Digest(std::string_view bytes) { return AsText(Hash(bytes)); }

struct DigestStream::State {
  struct Free {
    void operator()(XXH3_state_t* hash) const { XXH3_freeState(hash); }
  };
  std::unique_ptr<XXH3_state_t, Free> hash{XXH3_createState()};
};

DigestStream::DigestStream() : state_(std::make_unique<State>()) {
  XXH3_64bits_reset(state_->hash.get());
}

DigestStream::~DigestStream() = default;

void DigestStream::Add(std::string_view bytes) {
  XXH3_64bits_update(state_->hash.get(), bytes.data(), bytes.size());
}

std::string DigestStream::Text() const { return AsText(XXH3_64bits_digest(state_->hash.get())); }

}  // namespace sprout
