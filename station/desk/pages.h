#pragma once

#include <optional>
#include <string>
#include <vector>

#include "station/desk/opening.h"
#include "station/desk/ui.h"
#include "station/desk/workflow.h"

namespace enamel::station::desk {

using language::Words;

// A page that uses the whole window; values are shares of it.
inline const Ui::Page kWidePage{0.06f, 0.06f, 0.88f, 0.90f, false};
// A page with few words, in the middle; `top` and `height`: shares of the window.
constexpr Ui::Page Column(float top, float height, float width) {
  return {0.5f * (1 - width), top, width, height, false, true, false, 34};
}
inline constexpr Ui::Page kSignInPage = Column(0.015f, 0.975f, 0.64f);
// With room for an end that cannot be stored.
inline constexpr Ui::Page kHandInPage = Column(0.04f, 0.92f, 0.7f);

// What the person at the window has typed and ticked; all of it is forgotten at the sign-out.
struct TypedByPerson {
  std::string login_, password_, password_again_, search_, dentist_, anyway_, pin_, pin_again_,
      signer_;
  bool consent_ = false, as_reference_ = false;
  // A message sent to this chair, until the person dismisses it.
  struct Said {
    protocol::Remark remark;
    Workflow::Clock::time_point since;
  };
  std::optional<Said> said_;
  bool offered_ = false;  // the focus was moved to the start of the exercise shown
};

// Draws the page of the current place and passes choices to the workflow. Text being typed into
// fields is kept here, and forgotten on leaving.
class Pages : private TypedByPerson {
 public:
  Pages(Ui& ui, Workflow& flow, std::string station)
      : ui_(ui), flow_(flow), station_(std::move(station)) {}

  // One frame. True when the person wants to close the window.
  bool Draw();

 private:
  void SignIn();
  void FirstPassword();
  void Languages();
  void Exercises();
  // Cards below a heading, and what choosing each does.
  struct Section {
    std::string heading;  // empty: none
    std::vector<Card> cards;
    std::vector<std::function<void()>> steps;
  };
  std::vector<Section> Sections(bool grouped);
  void ExerciseList();
  void PracticeList();
  Card AttemptCard(const SpooledAttempt& attempt, std::string_view title, const std::string& text,
                   std::string_view right) const;
  void Exercise();
  void ExerciseFacts(const PreparedAttempt& prepared);
  void WarmUp();
  void Ready();
  void Running();
  void Remark(RunningAttempt& run);
  void HandIn();
  void Result();
  std::vector<Picture> PicturesOfResult();
  void BelowPictures();
  void Losses(const std::vector<Loss>& losses);
  void ShownLoss();
  void Practice();
  void PracticePaused();
  void Score(const scoring::ScoreResult& score);
  void Criterion(const scoring::CriterionResult& criterion);
  void ResultChoices();
  void Paused();
  void AskFinish();
  void AskGiveUp();
  void AskReference();
  void AskCutOff();
  void AskReserve();
  void AskPin();
  void AskSignOff();
  void Reserved();
  void Devices();
  void AskFallback();
  void ChosenDevice();
  void ExerciseChoices(bool prepared);
  bool AskClose();
  void Busy();
  std::string Say(std::string_view key, std::initializer_list<language::Value> values = {}) const {
    return flow_.words().Say(key, values);
  }

  Ui& ui_;
  Workflow& flow_;
  const std::string station_;
  Place before_ = Place::kSignIn;
  Dialog dialog_before_ = Dialog::kNone;
};

// Replaces all pages while the workplace cannot be opened ("trouble"): the problem, what is safe,
// and what to do. One frame. True when the person wants to close the window.
bool DrawOpeningProblem(Ui& ui, const Words& words, Opening& opening);

// The bur seen from the side, to scale, in the current ImGui window at the cursor.
void DrawBur(const cutting::Bur& bur, float width_px, float height_px, float mm_to_px);
// "Cylinder, 1.2 mm thick, 4.0 mm long".
std::string BurText(const Words& words, const cutting::Bur& bur);
// The same, and its ISO number and grit where it has them.
std::string BurText(const Words& words, const scene::BurSpec& bur);
// The burs of an exercise with several, over a picture: each from the side and to one scale, and a ring
// around the one in the handpiece. Words are left out where there is no room for them.
// Nothing for one bur.
void DrawBurChoice(const std::vector<scene::BurSpec>& burs, const render::FrameState& state,
                   const Words& words, const render::Fonts& fonts, const render::Canvas& canvas);

}  // namespace enamel::station::desk
