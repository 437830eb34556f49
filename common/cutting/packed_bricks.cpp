#include "common/cutting/packed_bricks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace enamel::cutting {
namespace {

constexpr int kPadding = 8;  // bytes that may be read past the last code

// Bits, the lowest of a byte first.
class BitWriter {
 public:
  explicit BitWriter(std::vector<uint8_t>& bytes) : bytes_(bytes) {}
  void Put(uint32_t value, int bits) {
    held_ |= uint64_t{value} << count_;
    for (count_ += bits; count_ >= 8; count_ -= 8) {
      bytes_.push_back(static_cast<uint8_t>(held_));
      held_ >>= 8;
    }
  }
  void Finish() {
    if (count_ > 0) bytes_.push_back(static_cast<uint8_t>(held_));
  }

 private:
  std::vector<uint8_t>& bytes_;
  uint64_t held_ = 0;
  int count_ = 0;
};

class BitReader {
 public:
  explicit BitReader(const uint8_t* bytes) noexcept : bytes_(bytes) {}
  // At least 57 of the next bits.
  uint64_t Peek() const noexcept {
    uint64_t next;
    std::memcpy(&next, bytes_ + (at_ >> 3), sizeof next);
    return next >> (at_ & 7);
  }
  void Skip(int bits) noexcept { at_ += static_cast<size_t>(bits); }
  uint32_t Take(int bits) noexcept {
    const auto value = static_cast<uint32_t>(Peek() & ((uint64_t{1} << bits) - 1));
    Skip(bits);
    return value;
  }

 private:
  const uint8_t* bytes_;
  size_t at_ = 0;
};

// Mean differences from the prediction that a brick starts with, times 16: those of a molar at 0.05 mm, rounded. By the
// number of axes along which a sample has no neighbour behind (0 to 3), and by the neighbours: distances; also samples
// at the limit; and 1 where the prediction is far beyond the limit. A wrong one costs bytes and nothing else
// (PackedBricksTest bounds the bytes).
constexpr int kStartInside[4] = {4, 40, 300, 8000};
constexpr int kNearLimit = 4;  // times as much
// Beyond the limit by half a voxel, a sample is at the limit nearly always.
constexpr int kFar = kPhiLimit + kPhiPerVoxel / 2;
// A predicted value is carried on this far: a brick's diagonal is 12 voxels, the band's end is 4.
constexpr int kFarthest = 16 * kPhiPerVoxel;
constexpr int kLongestRun = 16;  // of ones in a code; then the value itself follows
constexpr int kValueBits = 17;   // of what two samples can differ by, with its sign
constexpr int kTissueBits = 3;
static_assert(kTissueCount <= 1 << kTissueBits);

// One kind of sample: a mean over about the last eight, times 16.
struct Kind {
  int mean = 16;
  // The shortest code for values around the mean.
  int Bits() const noexcept {
    return mean <= 16 ? 0 : std::bit_width(static_cast<unsigned>(mean - 1)) - 4;
  }
  void Saw(uint32_t value) noexcept { mean += 2 * static_cast<int>(value) - (mean >> 3); }
};

// The samples of a brick in the order they are written, row by row, each predicted from those before.
class Predictor {
 public:
  Predictor() noexcept {
    for (int missing = 0; missing < 4; ++missing) {
      kinds_[missing][0].mean = 16 * kStartInside[missing];
      kinds_[missing][1].mean = 16 * kStartInside[missing] * kNearLimit;
      kinds_[missing][2].mean = 16;
    }
  }
  // The row along x at (y, z), whose first sample has the number i. Call in order.
  void StartRow(int i, int y, int z) noexcept {
    row_ = way_.data() + i;
    limits_ = at_limit_.data() + i;
    missing_ = (y == 0) + (z == 0);
    if (missing_ == 2) {
      for (int x = 0; x < kBrickSide; ++x) Given(x, 0, false);
      first_ = 0;
      return;
    }
    const uint8_t* const l = limits_;
    if (missing_ == 0) {
      const int* const w = row_;
      for (int x = 0; x < kBrickSide; ++x)
        Given(x, w[x - kY] + w[x - kZ] - w[x - kY - kZ],
              (l[x - kY] | l[x - kZ] | l[x - kY - kZ]) != 0);
      first_ = given_[0] + Mean(Bend(-kY, kZ, y), Bend(-kZ, kY, z), y, z);
      return;
    }
    // Of the two planes through the first row.
    step_ = y > 0 ? kY : kZ;
    along_ = y + z;
    for (int x = 0; x < kBrickSide; ++x) Given(x, row_[x - step_], l[x - step_] != 0);
    first_ = Extrapolated(row_, step_, along_);
  }
  // The row's sample x. Call in order, and Is after each.
  void Look(int x) noexcept {
    const auto n = static_cast<size_t>(x);
    if (x == 0) {
      predicted_ = first_;
      Choose(missing_ + 1, near_[0] != 0);
      return;
    }
    const bool near = (near_[n] | near_[n - 1] | limits_[x - 1]) != 0;
    if (missing_ == 0) {
      predicted_ = row_[x - 1] + given_[n] - given_[n - 1];
    } else if (missing_ == 1) {
      const int* const w = row_ + x;
      predicted_ = row_[x - 1] + given_[n] - given_[n - 1];
      const int by_row = x >= 2 ? w[-1] - w[-2] - given_[n - 1] + given_[n - 2] : 0;
      const int by_step =
          along_ >= 2 ? given_[n] - w[-2 * step_] - given_[n - 1] + w[-1 - 2 * step_] : 0;
      predicted_ += Mean(by_row, by_step, x, along_);
    } else {
      predicted_ = Extrapolated(row_ + x, 1, x);
    }
    Choose(missing_, near);
  }
  int Predicted() const noexcept { return std::clamp(predicted_, int{-kPhiLimit}, int{kPhiLimit}); }
  Kind& kind() noexcept { return *kind_; }
  void Is(int x, int sample) noexcept {
    int carried = sample;
    if (sample == kPhiLimit) carried = std::min(std::max(predicted_, sample), kFarthest);
    if (sample == -kPhiLimit) carried = std::max(std::min(predicted_, sample), -kFarthest);
    row_[x] = carried;
    limits_[x] = sample == kPhiLimit || sample == -kPhiLimit;
  }

 private:
  static constexpr int kY = kBrickSide, kZ = kBrickSide * kBrickSide;

  void Given(int x, int given, bool near) noexcept {
    given_[static_cast<size_t>(x)] = given;
    near_[static_cast<size_t>(x)] = near;
  }
  void Choose(int missing, bool near) noexcept {
    const bool far = predicted_ >= kFar || predicted_ <= -kFar;
    kind_ = &kinds_[missing][far ? 2 : near];
  }
  // Of degree two along `step`, of which there are n samples.
  static int Extrapolated(const int* w, int step, int n) noexcept {
    if (n >= 3) return 3 * (w[-step] - w[-2 * step]) + w[-3 * step];
    if (n == 2) return 2 * w[-step] - w[-2 * step];
    return n == 1 ? w[-step] : 0;
  }
  // How the mixed change of the first plane was one step `a` before, where there is one.
  int Bend(int a, int b, int along) const noexcept {
    const int* const w = row_;
    return along >= 2 ? w[a] - w[2 * a] - w[a - b] + w[2 * a - b] : 0;
  }
  static int Mean(int by_a, int by_b, int along_a, int along_b) noexcept {
    return along_a >= 2 && along_b >= 2 ? (by_a + by_b) / 2 : by_a + by_b;
  }

  std::array<int, kBrickVoxels> way_;  // the samples, carried on beyond the limit
  std::array<uint8_t, kBrickVoxels> at_limit_;
  // The current row: its place in both, what the rows before it add to its predictions, and the first of these.
  int* row_ = nullptr;
  uint8_t* limits_ = nullptr;
  int missing_ = 0, step_ = 0, along_ = 0, first_ = 0;
  std::array<int, kBrickSide> given_;
  std::array<uint8_t, kBrickSide> near_;
  Kind kinds_[4][3];
  Kind* kind_ = nullptr;
  int predicted_ = 0;
};

// 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
uint32_t Unsigned(int off) noexcept {
  return off >= 0 ? 2 * static_cast<uint32_t>(off) : 2 * static_cast<uint32_t>(-(off + 1)) + 1;
}
int Signed(uint32_t value) noexcept {
  return value & 1 ? -1 - static_cast<int>(value >> 1) : static_cast<int>(value >> 1);
}

void PutCode(BitWriter& out, uint32_t value, int bits) {
  const uint32_t run = value >> bits;
  if (run >= kLongestRun) {
    out.Put((1u << kLongestRun) - 1, kLongestRun);
    out.Put(value, kValueBits);
    return;
  }
  out.Put((1u << run) - 1, static_cast<int>(run) + 1);
  out.Put(value & ((1u << bits) - 1), bits);
}

uint32_t TakeCode(BitReader& in, int bits) noexcept {
  const uint64_t next = in.Peek();
  const int run = std::countr_one(next);
  if (run >= kLongestRun) {
    in.Skip(kLongestRun);
    return in.Take(kValueBits);
  }
  in.Skip(run + 1 + bits);
  return static_cast<uint32_t>(run) << bits |
         static_cast<uint32_t>(next >> (run + 1) & ((uint64_t{1} << bits) - 1));
}

// A sample's number, exclusive or this, is its place: the order begins at the corner where the fewest samples are at the
// limit, so that few distances come back from there.
uint32_t CornerOf(const BrickPhi& phi) noexcept {
  int at_limit[3][2] = {};
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (std::abs(phi.phi[static_cast<size_t>(i)]) != kPhiLimit) continue;
    for (int axis = 0; axis < 3; ++axis) ++at_limit[axis][i >> (3 * axis + 2) & 1];
  }
  uint32_t corner = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (at_limit[axis][0] > at_limit[axis][1]) corner |= 7u << (3 * axis);
  }
  return corner;
}

// Calls row(first sample) for all 64, in order.
template <typename Row>
void EachRow(Row&& row) {
  for (int z = 0; z < kBrickSide; ++z)
    for (int y = 0; y < kBrickSide; ++y) row((z * kBrickSide + y) * kBrickSide, y, z);
}

// Runs of one tissue along a row; a row like the one before it is a bit.
void PutLabels(BitWriter& out, const BrickLabels& labels) {
  const uint8_t* const t = labels.tissue.data();
  EachRow([&](int i, int y, int z) {
    const int before = y > 0 ? i - kBrickSide : i - kBrickSide * kBrickSide;
    const bool same = y + z > 0 && std::equal(t + i, t + i + kBrickSide, t + before);
    out.Put(same, 1);
    for (int x = 0, end; !same && x < kBrickSide; x = end) {
      for (end = x + 1; end < kBrickSide && t[i + end] == t[i + x];) ++end;
      out.Put(t[i + x], kTissueBits);
      out.Put(static_cast<uint32_t>(end - x - 1), 3);
    }
  });
}

void TakeLabels(BitReader& in, BrickLabels& labels) noexcept {
  uint8_t* const t = labels.tissue.data();
  EachRow([&](int i, int y, int) {
    if (in.Take(1) != 0) {
      std::memcpy(t + i, t + (y > 0 ? i - kBrickSide : i - kBrickSide * kBrickSide), kBrickSide);
      return;
    }
    for (int x = 0; x < kBrickSide;) {
      const auto tissue = static_cast<uint8_t>(in.Take(kTissueBits));
      for (uint32_t n = in.Take(3) + 1; n > 0 && x < kBrickSide; --n) t[i + x++] = tissue;
    }
  });
}

}  // namespace

void PackedBricks::Append(const BrickPhi& phi, const BrickLabels* labels, Tissue tissue) {
  if (!bytes_.empty()) bytes_.resize(bytes_.size() - kPadding);
  bricks_.push_back({static_cast<uint32_t>(bytes_.size()), *std::ranges::min_element(phi.phi),
                     tissue, labels != nullptr});
  BitWriter out(bytes_);
  const uint32_t corner = CornerOf(phi);
  for (int axis = 0; axis < 3; ++axis) out.Put(corner >> (3 * axis) & 1, 1);
  Predictor predictor;
  EachRow([&](int i, int y, int z) {
    // A row whose samples are all as predicted is a bit.
    predictor.StartRow(i, y, z);
    std::array<uint32_t, kBrickSide> off;
    std::array<int, kBrickSide> bits;
    uint32_t any = 0;
    for (int x = 0; x < kBrickSide; ++x) {
      const int sample = phi.phi[static_cast<uint32_t>(i + x) ^ corner];
      predictor.Look(x);
      const auto n = static_cast<size_t>(x);
      off[n] = Unsigned(sample - predictor.Predicted());
      bits[n] = predictor.kind().Bits();
      predictor.kind().Saw(off[n]);
      predictor.Is(x, sample);
      any |= off[n];
    }
    out.Put(any != 0, 1);
    if (any == 0) return;
    for (size_t x = 0; x < kBrickSide; ++x) PutCode(out, off[x], bits[x]);
  });
  if (labels != nullptr) PutLabels(out, *labels);
  out.Finish();
  bytes_.resize(bytes_.size() + kPadding);
  ENAMEL_CHECK(bytes_.size() < UINT32_MAX);
}

void PackedBricks::Unpack(size_t brick, BrickPhi& phi, BrickLabels* labels) const noexcept {
  BitReader in(bytes_.data() + bricks_[brick].first);
  uint32_t corner = 0;
  for (int axis = 0; axis < 3; ++axis) corner |= in.Take(1) * (7u << (3 * axis));
  Predictor predictor;
  EachRow([&](int i, int y, int z) {
    predictor.StartRow(i, y, z);
    const bool any = in.Take(1) != 0;
    for (int x = 0; x < kBrickSide; ++x) {
      predictor.Look(x);
      const uint32_t off = any ? TakeCode(in, predictor.kind().Bits()) : 0;
      predictor.kind().Saw(off);
      const int sample = predictor.Predicted() + Signed(off);
      predictor.Is(x, sample);
      phi.phi[static_cast<uint32_t>(i + x) ^ corner] = static_cast<int16_t>(sample);
    }
  });
  if (bricks_[brick].has_labels && labels != nullptr) TakeLabels(in, *labels);
}

void PackedBricks::ShrinkToFit() {
  bytes_.shrink_to_fit();
  bricks_.shrink_to_fit();
}

}  // namespace enamel::cutting
