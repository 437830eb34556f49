#pragma once

#include "station/render/gl_objects.h"

namespace enamel::station::render {

// Colours and gloss of the tissues and of Material (revolve.h), for the program in use.
void SetMaterials(const Program& program);

// The ghost of the hand.
glm::vec3 GhostColour();

}  // namespace enamel::station::render
