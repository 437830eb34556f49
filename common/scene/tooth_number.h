#pragma once

// Teeth by their FDI number (ISO 3950): two digits, the quadrant and the place from the middle of
// the jaw. Permanent teeth are 11 to 48 (places 1 to 8), deciduous ones 51 to 85 (places 1 to 5).
// Functions, any thread.
namespace enamel::scene {

constexpr bool IsToothNumber(int number) {
  const int quadrant = number / 10, place = number % 10;
  return quadrant >= 1 && quadrant <= 8 && place >= 1 && place <= (quadrant <= 4 ? 8 : 5);
}

// Incisors and canines.
constexpr bool IsAnterior(int tooth) { return IsToothNumber(tooth) && tooth % 10 <= 3; }

// A milk tooth.
constexpr bool IsDeciduous(int tooth) { return IsToothNumber(tooth) && tooth > 50; }

// Where mesial is in a scene's frame (types.h): +1, along +x, or -1, along -x. The frame is
// right-handed with buccal at +y and occlusal at +z. Look down on the lower jaw, so that occlusal
// points at you: +x is to the right of +y. A lower right tooth's buccal side faces the patient's
// right, so +x points to the back: distal. A lower left tooth is its mirror image, so there +x is
// mesial. An upper tooth is seen from below, which swaps the sides once more. 1 where there is no
// tooth.
constexpr int MesialX(int tooth) {
  const int quadrant = tooth / 10;
  return IsToothNumber(tooth) && quadrant % 2 == 0 ? -1 : 1;
}

}  // namespace enamel::scene
