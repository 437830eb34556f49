#include "common/trace/columns.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

namespace enamel::trace {
namespace {

// Codings of a column: the values, their first, second or third differences, or what is left of the
// differences after two other columns (`Followed`). Part of the format: more is refused.
constexpr int kMaxOrder = 3, kFollows = 4;

using Values = std::array<uint64_t, kMaxTicksPerChunk>;

// Which two columns' differences a column can follow, those of its own axis.
enum class Lead {
  kNone,
  kAnchor,  // its own a tick earlier, and the counts'
  kForce,   // the counts', and the anchor's
};

// One column: how a field is read from a tick, and put back. `set` is false when the value does not
// fit the field.
struct Column {
  const char* name;
  int64_t (*get)(const Tick&);
  bool (*set)(Tick&, int64_t);
  Lead lead = Lead::kNone;
  size_t axis = 0;
};

template <typename T>
bool Assign(T& field, int64_t value) {
  if (value < std::numeric_limits<T>::min() || value > std::numeric_limits<T>::max()) return false;
  field = static_cast<T>(value);
  return true;
}

template <auto kGroup, auto kField, size_t kAxis>
constexpr Column Axis(const char* name, Lead lead = Lead::kNone) {
  return {name, [](const Tick& t) -> int64_t { return (t.*kGroup.*kField)[kAxis]; },
          [](Tick& t, int64_t v) { return Assign((t.*kGroup.*kField)[kAxis], v); }, lead, kAxis};
}

template <auto kGroup, auto kField>
constexpr Column Scalar(const char* name) {
  return {name, [](const Tick& t) -> int64_t { return t.*kGroup.*kField; },
          [](Tick& t, int64_t v) { return Assign(t.*kGroup.*kField, v); }};
}

// Computed force as its difference to the sent one, which is in an earlier column. 0 in air, and else the
// friction that the motors leave out or push against, mostly all of c: it changes seldom.
template <size_t kAxis>
constexpr Column ComputedForce(const char* name) {
  return {name,
          [](const Tick& t) -> int64_t {
            return int64_t{t.witness.force_computed_mn[kAxis]} - t.witness.force_sent_mn[kAxis];
          },
          [](Tick& t, int64_t v) {
            // No difference of two 32-bit numbers is more; the sum below must not overflow.
            constexpr int64_t kWidest = int64_t{1} << 32;
            if (v < -kWidest || v > kWidest) return false;
            return Assign(t.witness.force_computed_mn[kAxis], v + t.witness.force_sent_mn[kAxis]);
          }};
}

using core::TickInput;
using core::TickWitness;

constexpr std::array<Column, kColumnCount - 3> kColumns = {{
    Axis<&Tick::input, &TickInput::orientation, 0>("orientation x"),
    Axis<&Tick::input, &TickInput::orientation, 1>("orientation y"),
    Axis<&Tick::input, &TickInput::orientation, 2>("orientation z"),
    Axis<&Tick::input, &TickInput::orientation, 3>("orientation w"),
    Scalar<&Tick::input, &TickInput::flags>("input flags"),
    Scalar<&Tick::input, &TickInput::bur_speed_krpm>("bur speed"),
    Scalar<&Tick::input, &TickInput::gap_ticks>("gap ticks"),
    Axis<&Tick::witness, &TickWitness::anchor_100nm, 0>("anchor x", Lead::kAnchor),
    Axis<&Tick::witness, &TickWitness::anchor_100nm, 1>("anchor y", Lead::kAnchor),
    Axis<&Tick::witness, &TickWitness::anchor_100nm, 2>("anchor z", Lead::kAnchor),
    Axis<&Tick::witness, &TickWitness::force_sent_mn, 0>("force sent x", Lead::kForce),
    Axis<&Tick::witness, &TickWitness::force_sent_mn, 1>("force sent y", Lead::kForce),
    Axis<&Tick::witness, &TickWitness::force_sent_mn, 2>("force sent z", Lead::kForce),
    ComputedForce<0>("force computed x"),
    ComputedForce<1>("force computed y"),
    ComputedForce<2>("force computed z"),
    Scalar<&Tick::witness, &TickWitness::flags>("witness flags"),
    Axis<&Tick::input, &TickInput::rest_off_nm, 0>("rest point off x"),
    Axis<&Tick::input, &TickInput::rest_off_nm, 1>("rest point off y"),
    Axis<&Tick::input, &TickInput::rest_off_nm, 2>("rest point off z"),
    Scalar<&Tick::input, &TickInput::share_lost>("share lost"),
}};

// In place; values before the first are 0. Unsigned, so that wrapping is defined.
void Difference(std::span<uint64_t> values) {
  uint64_t before = 0;
  for (uint64_t& v : values) {
    uint64_t here = v;
    v -= before;
    before = here;
  }
}

void Sum(std::span<uint64_t> values) {
  uint64_t sum = 0;
  for (uint64_t& v : values) v = sum += v;
}

uint64_t Zigzag(uint64_t v) {
  return (v << 1) ^ static_cast<uint64_t>(static_cast<int64_t>(v) >> 63);
}

// About what zstd makes of it. Bytes would not do: most numbers fit one.
size_t Bits(std::span<const uint64_t> values) {
  size_t bits = 0;
  for (uint64_t v : values) bits += static_cast<size_t>(std::bit_width(Zigzag(v)));
  return bits;
}

// In so many parts of 1, and at most 256: slope times a difference of 32 bits stays within 64 bits.
constexpr int kSlopeBits = 16;
constexpr int64_t kSteepest = int64_t{256} << kSlopeBits;

struct Slopes {
  int64_t first = 0, second = 0;
};

// How much the column changes if it follows. Wraps where the values are nonsense.
uint64_t Followed(const Slopes& slopes, int64_t first, int64_t second) {
  const uint64_t sum = static_cast<uint64_t>(slopes.first) * static_cast<uint64_t>(first) +
                       static_cast<uint64_t>(slopes.second) * static_cast<uint64_t>(second) +
                       (uint64_t{1} << (kSlopeBits - 1));
  return static_cast<uint64_t>(static_cast<int64_t>(sum) >> kSlopeBits);
}

// The differences at tick i > 0 that `column` follows; `values`: its own, known before i.
std::array<int64_t, 2> Leaders(const Column& column, std::span<const Tick> ticks,
                               std::span<const uint64_t> values, size_t i) {
  const size_t k = column.axis;
  const Tick &now = ticks[i], &before = ticks[i - 1];
  const int64_t counts = int64_t{now.input.counts[k]} - before.input.counts[k];
  if (column.lead == Lead::kForce) {
    return {counts, int64_t{now.witness.anchor_100nm[k]} - int64_t{before.witness.anchor_100nm[k]}};
  }
  const uint64_t own = i > 1 ? values[i - 1] - values[i - 2] : 0;
  return {static_cast<int64_t>(own), counts};
}

// Least squares, then twice with each tick's weight by how far it was off: nearer the least sum of
// sizes, which is what is paid for. A tick in which the bur meets another tissue is far off.
Slopes FitSlopes(const Column& column, std::span<const Tick> ticks,
                 std::span<const uint64_t> values) {
  double first = 0, second = 0;
  for (int round = 0; round < 3; ++round) {
    double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
    for (size_t i = 1; i < ticks.size(); ++i) {
      const auto lead = Leaders(column, ticks, values, i);
      const auto a = static_cast<double>(lead[0]), b = static_cast<double>(lead[1]);
      const auto y = static_cast<double>(static_cast<int64_t>(values[i] - values[i - 1]));
      const double weight = round == 0 ? 1 : 1 / (std::fabs(y - first * a - second * b) + 1);
      aa += weight * a * a;
      ab += weight * a * b;
      bb += weight * b * b;
      ay += weight * a * y;
      by += weight * b * y;
    }
    const double determinant = aa * bb - ab * ab;
    const bool both = determinant > 1e-9 * aa * bb;  // the two do not move as one
    first = both ? (ay * bb - by * ab) / determinant : aa > 0 ? ay / aa : 0;
    second = both ? (by * aa - ay * ab) / determinant : aa > 0 || bb == 0 ? 0 : by / bb;
  }
  auto whole = [](double slope) {
    const double parts =
        std::clamp(std::ldexp(slope, kSlopeBits), -1.0 * kSteepest, 1.0 * kSteepest);
    return static_cast<int64_t>(std::llround(parts));
  };
  return {whole(first), whole(second)};
}

void WriteColumn(const Column& column, std::span<const Tick> ticks, ByteWriter& out) {
  Values storage, best, own;
  std::span<uint64_t> values(storage.data(), ticks.size());
  for (size_t i = 0; i < ticks.size(); ++i) values[i] = static_cast<uint64_t>(column.get(ticks[i]));
  std::copy(values.begin(), values.end(), own.begin());
  int coding = 0;
  size_t least = std::numeric_limits<size_t>::max();
  // The first of several as short: equal ticks give equal bytes.
  auto offer = [&](int candidate, size_t bits) {
    if (bits >= least) return;
    coding = candidate;
    least = bits;
    std::copy(values.begin(), values.end(), best.begin());
  };
  for (int order = 0; order <= kMaxOrder; ++order) {
    if (order > 0) Difference(values);
    offer(order, Bits(values));
  }
  Slopes slopes;
  if (column.lead != Lead::kNone && ticks.size() > 1) {
    const std::span<const uint64_t> all(own.data(), ticks.size());
    slopes = FitSlopes(column, ticks, all);
    values[0] = own[0];
    for (size_t i = 1; i < ticks.size(); ++i) {
      const auto lead = Leaders(column, ticks, all, i);
      values[i] = own[i] - own[i - 1] - Followed(slopes, lead[0], lead[1]);
    }
    offer(kFollows, Bits(values) + 2 * kSlopeBits);
  }
  out.U8(static_cast<uint8_t>(coding));
  if (coding == kFollows) {
    out.SignedVarint(slopes.first);
    out.SignedVarint(slopes.second);
  }
  for (size_t i = 0; i < ticks.size(); ++i) out.SignedVarint(static_cast<int64_t>(best[i]));
}

Status Bad(const char* column, const std::string& what) {
  return Status(Code::kInvalidInput, std::string("chunk payload, column ") + column + ": " + what,
                column);
}

constexpr const char* kEndsEarly = "the payload ends early or holds a number over 64 bits";

Status ReadColumn(const Column& column, ByteReader& in, std::span<Tick> ticks) {
  Values storage;
  std::span<uint64_t> values(storage.data(), ticks.size());
  const int coding = in.U8();
  const bool follows = coding == kFollows && column.lead != Lead::kNone;
  if (coding > kMaxOrder && !follows) {
    return Bad(column.name, "expected a difference order of 0 to 3" +
                                std::string(column.lead != Lead::kNone ? " or 4" : "") +
                                ", found " + std::to_string(coding));
  }
  Slopes slopes;
  if (follows) {
    slopes = {in.SignedVarint(), in.SignedVarint()};
    for (int64_t slope : {slopes.first, slopes.second}) {
      if (slope < -kSteepest || slope > kSteepest) {
        return Bad(column.name, "a slope of " + std::to_string(slope) + " is too steep");
      }
    }
  }
  for (uint64_t& v : values) v = static_cast<uint64_t>(in.SignedVarint());
  if (!in.ok()) return Bad(column.name, kEndsEarly);
  // Wraps as Difference did; whether the outcome fits its field is asked last.
  for (int i = 0; i < coding && !follows; ++i) Sum(values);
  for (size_t i = 1; i < ticks.size() && follows; ++i) {
    const auto lead = Leaders(column, ticks, values, i);
    values[i] += values[i - 1] + Followed(slopes, lead[0], lead[1]);
  }
  for (size_t i = 0; i < ticks.size(); ++i) {
    if (!column.set(ticks[i], static_cast<int64_t>(values[i]))) {
      return Bad(column.name, "value " + std::to_string(static_cast<int64_t>(values[i])) +
                                  " of tick " + std::to_string(i) + " does not fit the field");
    }
  }
  return Status::Ok();
}

// The way of the counts since the tick before; of the first tick: from 0.
std::array<int64_t, 3> CountsMoved(std::span<const Tick> ticks, size_t i) {
  std::array<int64_t, 3> out{};
  for (size_t k = 0; k < 3; ++k) {
    out[k] = int64_t{ticks[i].input.counts[k]} - (i > 0 ? ticks[i - 1].input.counts[k] : 0);
  }
  return out;
}

// Three axes at once: a reading stays for several ticks and then jumps along all of them.
void WriteCounts(std::span<const Tick> ticks, ByteWriter& out) {
  std::array<uint8_t, kMaxTicksPerChunk / 8> moved{};
  ByteWriter ways;
  for (size_t i = 0; i < ticks.size(); ++i) {
    const auto way = CountsMoved(ticks, i);
    if (way == std::array<int64_t, 3>{}) continue;
    moved[i / 8] |= static_cast<uint8_t>(1u << i % 8);
    for (int64_t part : way) ways.SignedVarint(part);
  }
  out.Raw(ByteView(moved).first((ticks.size() + 7) / 8));
  out.Raw(ways.bytes());
}

Status ReadCounts(ByteReader& in, std::span<Tick> ticks) {
  const ByteView moved = in.Raw((ticks.size() + 7) / 8);
  if (!in.ok()) return Bad("counts", kEndsEarly);
  if (ticks.size() % 8 != 0 && moved.back() >> ticks.size() % 8 != 0) {
    return Bad("counts", "a tick beyond the last one moves");
  }
  std::array<int32_t, 3> at{};
  for (size_t i = 0; i < ticks.size(); ++i) {
    for (size_t k = 0; k < 3 && (moved[i / 8] >> i % 8 & 1) != 0; ++k) {
      // A sum that wraps is far outside the field.
      const auto value = static_cast<int64_t>(static_cast<uint64_t>(int64_t{at[k]}) +
                                              static_cast<uint64_t>(in.SignedVarint()));
      if (!in.ok()) return Bad("counts", kEndsEarly);
      if (!Assign(at[k], value)) {
        return Bad("counts", "value " + std::to_string(value) + " of tick " + std::to_string(i) +
                                 " does not fit the field");
      }
    }
    ticks[i].input.counts = at;
  }
  return Status::Ok();
}

}  // namespace

Bytes EncodeColumns(std::span<const Tick> ticks) {
  ENAMEL_CHECK(ticks.size() <= kMaxTicksPerChunk);
  ByteWriter out;
  WriteCounts(ticks, out);
  for (const Column& column : kColumns) WriteColumn(column, ticks, out);
  return out.Take();
}

Result<std::vector<Tick>> DecodeColumns(ByteView payload, size_t count) {
  ENAMEL_CHECK(count <= kMaxTicksPerChunk);
  std::vector<Tick> ticks(count);
  ByteReader in(payload);
  ENAMEL_RETURN_IF_ERROR(ReadCounts(in, ticks));
  for (const Column& column : kColumns) ENAMEL_RETURN_IF_ERROR(ReadColumn(column, in, ticks));
  if (!in.AtEnd()) {
    return Status(Code::kInvalidInput, "chunk payload: " + std::to_string(in.remaining()) +
                                           " bytes left over after the last column");
  }
  return ticks;
}

}  // namespace enamel::trace
