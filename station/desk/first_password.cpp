// A password in place of a one-time one: its page, and its step.
#include "station/desk/first_password.h"

#include <string_view>

#include "common/base/password.h"
#include "common/base/utf8.h"
#include "station/desk/pages.h"
#include "station/desk/workflow.h"

namespace enamel::station::desk {
namespace {

int64_t CharactersOf(std::string_view text) {
  int64_t count = 0;
  while (!text.empty()) {
    if (!NextCodePoint(text)) text.remove_prefix(1);
    ++count;
  }
  return count;
}

}  // namespace

std::string ProblemOfPassword(const Words& words, const std::string& one_time,
                              const std::string& chosen, const std::string& again) {
  constexpr auto kLeast = static_cast<int64_t>(kMinPasswordLength);
  if (const int64_t found = CharactersOf(chosen); found < kLeast) {
    return words.Say("first_password.too_short", {{"least", kLeast}, {"found", found}});
  }
  if (chosen.size() > kMaxPasswordLength) return words.Say("first_password.too_long");
  if (chosen == one_time) return words.Say("first_password.same");
  return chosen == again ? std::string() : words.Say("first_password.different");
}

void Workflow::ChoosePassword(const std::string& chosen, const std::string& again) {
  if (busy() || place_ != Place::kFirstPassword) return;
  problem_ = ProblemOfPassword(words_, signing_in_.one_time, chosen, again);
  if (!problem_.empty()) return;
  task_.Start("task.password", [this, who = signing_in_, chosen]() -> BackgroundTask::After {
    const auto person = workplace_.SignInChoosing(who.login, who.one_time, chosen);
    const Status& s = person.status();
    // Of the server's rules only one is not checked here.
    if (s.code() == Code::kInvalidInput && s.field() == kNewPassword) {
      return [this] { problem_ = words_.Say("first_password.too_easy"); };
    }
    // The one-time password has expired, or somebody has replaced it: no other helps here.
    if (s.code() == Code::kUnauthenticated)
      return [this, s] {
        SignOut();
        Fail(s);
      };
    return SignedIn(person, who);
  });
}

void Pages::FirstPassword() {
  ui_.Begin("first-password", Column(0.02f, 0.96f, 0.6f));
  ui_.Title(Say("first_password.title"));
  ui_.Text(Say("first_password.text"));
  if (ui_.Field(Say("first_password.new"), password_, true)) ui_.Focus(Say("first_password.again"));
  ui_.Note(Say("first_password.hint", {{"least", static_cast<int64_t>(kMinPasswordLength)}}));
  bool go = ui_.Field(Say("first_password.again"), password_again_, true);
  ui_.Problem(flow_.problem());
  Busy();
  const bool free = !flow_.busy();
  go |= ui_.Button(Say("first_password.set"), Ui::Look::kMain, free);
  if (go && free) {
    flow_.ChoosePassword(password_, password_again_);
    // Not kept after sending, whatever the server answers.
    password_.clear();
    password_again_.clear();
    ui_.Focus(Say("first_password.new"));
  }
  ui_.SameLine();
  if (ui_.Button(Say("exercise.back")) || ui_.escape()) flow_.Back();
  ui_.End();
}

}  // namespace enamel::station::desk
