#include "station/lab/grades/operator_run.h"

#include "common/scene/plan.h"
#include "station/loop/tick_loop.h"

namespace enamel::station::lab {

Result<cutting::Volume> RunOperator(
    const OperatorPreset& preset, const scene::BuiltScene& built, const scene::Exercise& exercise,
    const scene::DeviceProfile& profile, uint64_t seed, uint64_t most_ticks,
    const std::function<void(const core::CoreParams&, const trace::Tick&)>& seen) {
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(built.scene, exercise, profile));
  ENAMEL_ASSIGN_OR_RETURN(auto device, MakeSimulatedDevice(preset, built.scene, exercise, profile,
                                                           params, built.volume, seed));
  core::Core core(params, built.volume);
  SampleRing ring(4);
  TickLoop loop(*device, core, ring, {params.rate_hz, true, false});
  bool finished = false;
  for (uint64_t i = 0; !finished && i < most_ticks; ++i) {
    finished = loop.Tick();
    Sample sample;
    while (ring.Pop(sample)) seen(params, sample.tick);
  }
  return core.volume();
}

}  // namespace enamel::station::lab
