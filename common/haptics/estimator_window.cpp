#include <array>
#include <cmath>

#include "common/haptics/estimator.h"

// Estimators that look back over samples: fixed window, and the first-order adaptive windows.
namespace enamel::haptics {
namespace {

// The last kSize positions, newest first.
template <int kSize>
class History {
 public:
  void Reset(double p) noexcept {
    size_ = 1;
    head_ = 0;
    values_[0] = p;
  }
  void Push(double p) noexcept {
    head_ = (head_ + 1) % kSize;
    values_[static_cast<size_t>(head_)] = p;
    if (size_ < kSize) ++size_;
  }
  int size() const noexcept { return size_; }
  double Back(int i) const noexcept {
    return values_[static_cast<size_t>((head_ - i + kSize) % kSize)];
  }

 private:
  std::array<double, kSize> values_{};
  int head_ = 0, size_ = 1;
};

int Limited(int v, int lo, int hi) noexcept { return v < lo ? lo : v > hi ? hi : v; }

class Window final : public VelocityEstimator {
 public:
  explicit Window(const EstimatorParams& p)
      : ticks_(Limited(p.window_ticks, 1, kLongest)), tick_s_(p.tick_s) {}
  void Reset(double p) noexcept override { history_.Reset(p); }
  double Update(double p) noexcept override {
    history_.Push(p);
    int n = history_.size() - 1 < ticks_ ? history_.size() - 1 : ticks_;
    return (p - history_.Back(n)) / (n * tick_s_);
  }
  void VisitState(StateArchive& archive) override { archive(history_); }

 private:
  static constexpr int kLongest = 1024;
  History<kLongest + 1> history_;
  int ticks_;
  double tick_s_;
};

// Grows the window back while every sample in it stays within delta of the line through its ends;
// the best fit takes the least-squares slope of the same window. Sample i ticks back allows the
// slopes within delta / i of its own; their intersection [low, high] is carried along, so each step
// back is O(1).
class Foaw final : public VelocityEstimator {
 public:
  Foaw(const EstimatorParams& p, bool best_fit)
      : best_fit_(best_fit),
        ticks_(Limited(p.window_ticks, 2, kLongest)),
        tick_s_(p.tick_s),
        delta_(p.resolution_m) {}
  void Reset(double p) noexcept override { history_.Reset(p); }
  double Update(double p) noexcept override {
    history_.Push(p);
    int reach = history_.size() - 1 < ticks_ ? history_.size() - 1 : ticks_;
    double slope = 0, low = -1e300, high = 1e300;
    double sum_y = 0, sum_iy = 0, sum_i = 0, sum_ii = 0;
    for (int i = 1; i <= reach; ++i) {
      double y = p - history_.Back(i), n = i;
      sum_y += y;
      sum_iy += n * y;
      sum_i += n;
      sum_ii += n * n;
      double from = (y - delta_) / n, to = (y + delta_) / n;
      low = from > low ? from : low;
      high = to < high ? to : high;
      double ends = y / n;
      if (ends < low || ends > high) break;
      slope = best_fit_ ? ((n + 1) * sum_iy - sum_i * sum_y) / ((n + 1) * sum_ii - sum_i * sum_i)
                        : ends;
    }
    return slope / tick_s_;
  }
  void VisitState(StateArchive& archive) override { archive(history_); }

 private:
  static constexpr int kLongest = 256;
  History<kLongest + 1> history_;
  bool best_fit_;
  int ticks_;
  double tick_s_, delta_;
};

}  // namespace

std::unique_ptr<VelocityEstimator> MakeBackwardDifference(const EstimatorParams& params) {
  EstimatorParams one = params;
  one.window_ticks = 1;
  return std::make_unique<Window>(one);
}
std::unique_ptr<VelocityEstimator> MakeWindowEstimator(const EstimatorParams& params) {
  return std::make_unique<Window>(params);
}
std::unique_ptr<VelocityEstimator> MakeFoawEndFit(const EstimatorParams& params) {
  return std::make_unique<Foaw>(params, false);
}
std::unique_ptr<VelocityEstimator> MakeFoawBestFit(const EstimatorParams& params) {
  return std::make_unique<Foaw>(params, true);
}

}  // namespace enamel::haptics
