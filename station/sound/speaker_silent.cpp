#include "station/sound/speaker.h"

namespace enamel::station::sound {

class Speaker::Impl {};

Speaker::Speaker() = default;
Speaker::~Speaker() = default;
void Speaker::Set(double, double) {}
void Speaker::Warn(Hazard, double) {}
bool Speaker::audible() const { return false; }

}  // namespace enamel::station::sound
