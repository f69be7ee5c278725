#include "common/core/pair_names.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <numeric>
#include <utility>

#include "common/core/number_text.h"
#include "common/core/quantile.h"

namespace sprout {
namespace {

using Tokens = std::vector<std::string_view>;

constexpr size_t kSecondDigits = 10;  // 2001 to 2286
constexpr size_t kNanosecondDigits = 9;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Numbers, words, and single characters between them.
Tokens Split(std::string_view name) {
  Tokens tokens;
  for (size_t at = 0; at < name.size();) {
    size_t end = at + 1;
    if (IsDigit(name[at])) {
      while (end < name.size() && IsDigit(name[end])) ++end;
    } else if (IsLetter(name[at])) {
      while (end < name.size() && IsLetter(name[end])) ++end;
    }
    tokens.push_back(name.substr(at, end - at));
    at = end;
  }
  return tokens;
}

std::string_view WithoutZeros(std::string_view digits) {
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size() - 1));
}

using Keys = std::vector<std::string>;

// Keys whose numbers have no leading zeros.
Keys Normal(const Keys& keys) {
  Keys normal;
  for (const std::string& key : keys) {
    std::string& text = normal.emplace_back();
    for (const std::string_view token : Split(key)) {
      text += IsDigit(token.front()) ? WithoutZeros(token) : token;
    }
  }
  return normal;
}

Keys Stems(std::span<const std::string> paths) {
  Keys keys;
  for (const std::string& path : paths) keys.push_back(std::filesystem::path(path).stem());
  return keys;
}

size_t CommonPrefix(const Tokens& a, const Tokens& b, size_t most) {
  const size_t length = std::min({a.size(), b.size(), most});
  size_t same = 0;
  while (same < length && a[same] == b[same]) ++same;
  return same;
}

// What differs within a list of paths.
Keys Differences(std::span<const std::string> paths) {
  std::vector<Tokens> all;
  for (const std::string& path : paths) all.push_back(Split(path));
  size_t before = all.front().size();
  for (const Tokens& tokens : all) before = CommonPrefix(tokens, all.front(), before);
  const auto rest_reversed = [&](const Tokens& tokens) {
    return Tokens(tokens.rbegin(), tokens.rend() - static_cast<std::ptrdiff_t>(before));
  };
  const Tokens first_rest = rest_reversed(all.front());
  size_t behind = first_rest.size();
  for (const Tokens& tokens : all) behind = CommonPrefix(rest_reversed(tokens), first_rest, behind);
  Keys keys;
  for (const Tokens& tokens : all) {
    std::string& key = keys.emplace_back();
    for (size_t i = before; i < tokens.size() - behind; ++i) key += tokens[i];
  }
  return keys;
}

bool AreDifferent(Keys keys) {
  std::ranges::sort(keys);
  return std::ranges::adjacent_find(keys) == keys.end();
}

// Where fractions have up to nine digits they are nanoseconds, written without leading zeros.
std::optional<std::vector<int64_t>> Stamps(const Keys& keys) {
  constexpr size_t kFraction = kSecondDigits + 1;
  size_t most = 0;
  for (const std::string& key : keys) most = std::max(most, key.size());
  std::vector<int64_t> stamps;
  for (std::string key : keys) {
    const bool is_short = most == kFraction + kNanosecondDigits && key.size() > kFraction;
    if (is_short && !IsDigit(key[kSecondDigits])) key.insert(kFraction, most - key.size(), '0');
    const std::optional<int64_t> stamp = StampOf(key);
    if (!stamp) return std::nullopt;
    stamps.push_back(*stamp);
  }
  return stamps;
}

// The part of each name from a number of seconds on, with its fraction. Names of one second begin
// alike, so Differences() would take the seconds for what all names begin with.
Keys TimesIn(const Keys& stems) {
  Keys keys;
  for (const std::string& stem : stems) {
    const Tokens tokens = Split(stem);
    std::string& key = keys.emplace_back();
    for (size_t i = 0; i < tokens.size() && key.empty(); ++i) {
      if (!IsDigit(tokens[i].front()) || tokens[i].size() < kSecondDigits) continue;
      const bool has_fraction = tokens[i].size() == kSecondDigits && i + 2 < tokens.size() &&
                                IsDigit(tokens[i + 2].front()) &&
                                (tokens[i + 1] == "." || tokens[i + 2].size() == kNanosecondDigits);
      // Ten digits alone may be a serial number.
      if (tokens[i].size() == kSecondDigits && !has_fraction) continue;
      key = tokens[i];
      if (!has_fraction) continue;
      key += tokens[i + 1];
      key += tokens[i + 2];
    }
  }
  // A number that all names have is no time, but a serial number.
  if (std::ranges::adjacent_find(keys, std::not_equal_to<>()) == keys.end()) {
    keys.assign(keys.size(), "");
  }
  return keys;
}

// Two files of one folder that have one key.
std::optional<std::string> Doubled(std::span<const std::string> paths, const Keys& keys) {
  std::map<std::pair<std::filesystem::path, std::string>, size_t> places;
  for (size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].empty()) continue;
    const auto folder = std::filesystem::path(paths[i]).parent_path();
    const auto [before, is_new] = places.try_emplace({folder, keys[i]}, i);
    if (!is_new) return paths[before->second] + " and " + paths[i];
  }
  return std::nullopt;
}

// The indices of a list in its order.
template <typename Values, typename Before>
std::vector<size_t> Order(const Values& values, Before before) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, [&](size_t a, size_t b) { return before(values[a], values[b]); });
  return order;
}

PairedNames ByTime(std::vector<int64_t> first, std::vector<int64_t> second, double max_spread_ms) {
  const std::vector<size_t> order_first = Order(first, std::less<>());
  const std::vector<size_t> order_second = Order(second, std::less<>());
  std::ranges::sort(first);
  std::ranges::sort(second);
  PairedNames paired = PairTimes(first, second, max_spread_ms);
  for (auto& [a, b] : paired.pairs) {
    a = order_first[a];
    b = order_second[b];
  }
  for (size_t& i : paired.alone_first) i = order_first[i];
  for (size_t& i : paired.alone_second) i = order_second[i];
  return paired;
}

// Nothing when no key is in both lists, or one twice in one of them, or there is but one name in a
// list, in which nothing differs.
std::optional<PairedNames> ByKey(const Keys& first, const Keys& second) {
  if (!AreDifferent(first) || !AreDifferent(second) || first[0].empty() || second[0].empty()) {
    return std::nullopt;
  }
  std::map<std::string, size_t> places;
  for (size_t i = 0; i < second.size(); ++i) places[second[i]] = i;
  PairedNames paired{.by = PairedBy::kName};
  for (const size_t i : Order(first, ComesBefore)) {
    const auto found = places.find(first[i]);
    if (found == places.end()) {
      paired.alone_first.push_back(i);
    } else {
      paired.pairs.push_back({i, found->second});
      places.erase(found);
    }
  }
  if (paired.pairs.empty()) return std::nullopt;
  for (const size_t i : Order(second, ComesBefore)) {
    if (places.contains(second[i])) paired.alone_second.push_back(i);
  }
  return paired;
}

// Numbers of two lists that count the same, such as milliseconds since a camera was started.
struct Counts {
  std::vector<int64_t> first;
  std::vector<int64_t> second;
  int64_t step = 0;  // the median one within the lists
};

// What stands behind the first number of a key, with zeros for digits: ".000", "_000000_000".
std::string ShapeBehindNumber(const std::string& key) {
  std::string shape = key.substr(std::min(key.find_first_not_of("0123456789"), key.size()));
  std::ranges::replace_if(shape, IsDigit, '0');
  return shape;
}

// Nothing where keys are no numbers, or dates, of one shape.
std::optional<std::vector<int64_t>> NumbersOf(const Keys& keys, const std::string& shape) {
  std::vector<int64_t> numbers;
  for (const std::string& key : keys) {
    if (key.empty() || !IsDigit(key.front()) || ShapeBehindNumber(key) != shape) return {};
    std::string digits;
    std::ranges::copy_if(key, std::back_inserter(digits), IsDigit);
    const std::optional<int64_t> number = ParseNumber<int64_t>(digits);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<Counts> CountsOf(const Keys& first, const Keys& second) {
  const std::string shape = ShapeBehindNumber(first.front());
  const bool is_plain = shape.find_first_not_of("0._-") == std::string::npos;
  auto numbers_first = NumbersOf(first, shape);
  auto numbers_second = NumbersOf(second, shape);
  if (!is_plain || !numbers_first || !numbers_second) return {};
  std::vector<int64_t> steps;
  for (std::vector<int64_t> numbers : {*numbers_first, *numbers_second}) {
    std::ranges::sort(numbers);
    for (size_t i = 1; i < numbers.size(); ++i) steps.push_back(numbers[i] - numbers[i - 1]);
  }
  if (steps.empty()) return {};
  return Counts{*std::move(numbers_first), *std::move(numbers_second), Median(steps)};
}

// Each with the nearest, where that is clearly nearer than the next one for most of a list.
std::optional<PairedNames> ByNumber(const Counts& counts) {
  const double most_ms = 1e-6 * static_cast<double>(counts.step) / 4;  // as if they were ns
  PairedNames paired = ByTime(counts.first, counts.second, most_ms);
  const size_t most = std::min(counts.first.size(), counts.second.size());
  return 2 * paired.pairs.size() > most ? std::optional(std::move(paired)) : std::nullopt;
}

// The first file from which on an order joins what does not belong together: one list makes a step
// that the other does not make.
std::optional<size_t> FindJump(const Counts& counts, const std::vector<PairedNames::Pair>& pairs) {
  for (size_t i = 1; i < pairs.size(); ++i) {
    const int64_t step_first = counts.first[pairs[i].first] - counts.first[pairs[i - 1].first];
    const int64_t step_second = counts.second[pairs[i].second] - counts.second[pairs[i - 1].second];
    if (std::abs(step_first - step_second) > counts.step / 2) return i;
  }
  return std::nullopt;
}

Result<PairedNames> ByOrder(std::span<const std::string> first, std::span<const std::string> second,
                            const std::optional<Counts>& counts) {
  PairedNames paired{.by = PairedBy::kOrder};
  const std::vector<size_t> order_first = Order(first, ComesBefore);
  const std::vector<size_t> order_second = Order(second, ComesBefore);
  for (size_t i = 0; i < first.size(); ++i)
    paired.pairs.push_back({order_first[i], order_second[i]});
  const std::optional<size_t> jump = counts ? FindJump(*counts, paired.pairs) : std::nullopt;
  if (!jump) return paired;
  const auto [a, b] = paired.pairs[*jump];
  return Fail("neither times nor equal names, nor does their order fit: before " + first[a] +
              " or before " + second[b] +
              " a file is missing; allowed: equal names, or times as names");
}

}  // namespace

std::optional<int64_t> StampOf(std::string_view name) {
  constexpr size_t kGpsDigits = 18;  // nanoseconds, 1973 to 2001: Argoverse counts from GPS's begin
  const auto is_number = [](std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, IsDigit);
  };
  if (name.size() < kSecondDigits || name.front() == '0') return std::nullopt;
  if (name.size() == kGpsDigits && is_number(name)) return ParseNumber<int64_t>(name);
  const std::string_view seconds = name.substr(0, kSecondDigits);
  std::string_view fraction = name.substr(kSecondDigits);
  const bool has_point = !fraction.empty() && !IsDigit(fraction.front());
  if (has_point) {
    const char point = fraction.front();
    if (point != '.' && point != '_' && point != '-') return std::nullopt;
    fraction.remove_prefix(1);
    if (!is_number(fraction) || (point != '.' && fraction.size() < 6)) return std::nullopt;
  }
  if (!is_number(seconds) || (!fraction.empty() && !is_number(fraction)) ||
      fraction.size() > kNanosecondDigits || (!has_point && fraction.size() % 3 != 0)) {
    return std::nullopt;
  }
  std::string digits(seconds);
  digits += fraction;
  digits.resize(kSecondDigits + kNanosecondDigits, '0');
  return ParseNumber<int64_t>(digits);
}

bool ComesBefore(std::string_view a, std::string_view b) {
  const Tokens tokens_a = Split(a);
  const Tokens tokens_b = Split(b);
  for (size_t i = 0; i < std::min(tokens_a.size(), tokens_b.size()); ++i) {
    std::string_view x = tokens_a[i];
    std::string_view y = tokens_b[i];
    if (IsDigit(x.front()) && IsDigit(y.front())) {
      x = WithoutZeros(x);
      y = WithoutZeros(y);
      if (x.size() != y.size()) return x.size() < y.size();
    }
    if (x != y) return x < y;
  }
  if (tokens_a.size() != tokens_b.size()) return tokens_a.size() < tokens_b.size();
  return a < b;  // 07 and 7
}

Result<PairedNames> PairNames(std::span<const std::string> first,
                              std::span<const std::string> second, double max_spread_ms) {
  if (first.empty() || second.empty()) return Fail("no file");
  const Keys stems[] = {Stems(first), Stems(second)};
  const Keys differences[] = {Differences(first), Differences(second)};
  const Keys times[] = {TimesIn(stems[0]), TimesIn(stems[1])};
  for (const auto& keys : {stems, times, differences}) {
    const auto stamps_first = Stamps(keys[0]);
    const auto stamps_second = Stamps(keys[1]);
    if (stamps_first && stamps_second) {
      PairedNames paired = ByTime(*stamps_first, *stamps_second, max_spread_ms);
      if (!paired.pairs.empty()) return paired;
      return Fail("the times in their names differ by " +
                  std::to_string(std::llround(paired.least_spread_ms)) +
                  " ms or more; allowed: " + std::to_string(std::llround(max_spread_ms)) + " ms");
    }
  }
  for (const auto& keys : {stems, differences}) {
    if (std::optional<PairedNames> paired = ByKey(Normal(keys[0]), Normal(keys[1])))
      return *std::move(paired);
  }
  // Numbers with a point: 0.05 and 0.5 are not one, nor are they doubled.
  const std::optional<PairedNames> same = ByKey(stems[0], stems[1]);
  if (same && same->alone_first.empty() && same->alone_second.empty()) return *same;
  // In their order all files behind a doubled one would get a wrong partner.
  for (const auto& keys : {stems, differences}) {
    std::optional<std::string> doubled = Doubled(first, Normal(keys[0]));
    if (!doubled) doubled = Doubled(second, Normal(keys[1]));
    if (doubled) return Fail(*doubled + " have one name or number; allowed: one of them");
  }
  std::optional<Counts> counts;
  for (const auto& keys : {stems, differences}) {
    if (!counts) counts = CountsOf(keys[0], keys[1]);
  }
  if (auto paired = counts ? ByNumber(*counts) : std::nullopt) return *std::move(paired);
  if (first.size() != second.size()) {
    return Fail("neither times nor names say which of " + std::to_string(first.size()) + " and " +
                std::to_string(second.size()) +
                " files belong together; allowed: equal names, times as names, or as many");
  }
  return ByOrder(first, second, counts);
}

}  // namespace sprout
