#include "station/desk/ui.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <optional>
#include <utility>

#include "station/desk/script.h"
#include "tests/station/render/virtual_display.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

using render::InputEvent;

class UiTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: no Xvfb";
    // The screen has 24 inches: letters are in proportion to the window.
    screen_.emplace(render::ScreenOptions{.width_px = 640,
                                          .height_px = 360,
                                          .pixel_mm = 3 * render::kReferencePixel_mm,
                                          .visible = false});
    ui_.emplace(*screen_);
  }

  // Runs frames until all injected input has been taken, and two more.
  template <typename Page>
  void Play(Page&& page) {
    int more = 2;
    while (more > 0) {
      if (!screen_->injecting()) --more;
      (void)screen_->Begin();
      page();
      ui_->EndFrame();
      screen_->End();
    }
  }
  void Press(int key) { screen_->Inject(InputEvent::Key(key, true)); }
  void Repeat(int key) { screen_->Inject(InputEvent::Key(key, true, 0, true)); }
  void Release(int key) { screen_->Inject(InputEvent::Key(key, false)); }
  void ClickChoice(size_t index) {
    const Rect at = ui_->choices().at(index).at;
    screen_->Inject(InputEvent::Cursor(0.5 * (at.x0 + at.x1), 0.5 * (at.y0 + at.y1)));
    screen_->Inject(InputEvent::Button(render::kMouseLeft, true));
    screen_->Inject(InputEvent::Button(render::kMouseLeft, false));
  }

  render::VirtualDisplay display_;
  std::optional<render::Screen> screen_;
  std::optional<Ui> ui_;
};

TEST_F(UiTest, AProblemIsASentenceOnThePage) {
  Play([&] {
    ui_->Begin("page");
    ui_->Problem("login or password is wrong");
    ui_->Problem("6 digits");
    ui_->Problem("");
    ui_->End();
  });
  EXPECT_EQ(ui_->words(), "Login or password is wrong\n6 digits\n");
}

// Corners of question marks that stand for letters without a shape, in the last frame.
int Substitutes() {
  int found = 0;
  const ImDrawData& drawn = *ImGui::GetDrawData();
  for (const ImFont* font : ImGui::GetIO().Fonts->Fonts) {
    for (int i = 0; i < drawn.CmdListsCount; ++i)
      for (const ImDrawVert& corner : drawn.CmdLists[i]->VtxBuffer)
        found += corner.uv.x == font->FallbackGlyph->U0 && corner.uv.y == font->FallbackGlyph->V0;
  }
  return found;
}

TEST_F(UiTest, WordsOfEveryScriptAreDrawnWhereverOthersWrite) {
  if (!render::FindFont()) GTEST_SKIP() << "skipped: no DejaVu";
  const std::string word = "\u0645\u062d\u0645\u062f";
  bool value = false;
  const Card card{word, {word}, word, {}};
  const Picture picture{0, word};
  const std::pair<const char*, std::function<void()>> widgets[] = {
      {"title", [&] { ui_->Title(word); }},
      {"one line", [&] { ui_->OneLine(word); }},
      {"text", [&] { ui_->Text(word); }},
      {"row", [&] { ui_->Row(word, word, word); }},
      {"line", [&] { ui_->Line(word, word, word, true); }},
      {"cards",
       [&] {
         ui_->Cards({&card, 1}, word);
       }},
      {"button", [&] { ui_->Button(word); }},
      {"check", [&] { ui_->Check(word, value); }},
      {"remark", [&] { ui_->Remark(word, word, "R closes this"); }},
      {"by hand", [&] { ImGui::TextUnformatted(word.c_str()); }}};
  for (const auto& widget : widgets) {
    Play([&] {
      ui_->Begin(widget.first);
      widget.second();
      ui_->End();
    });
    const bool by_hand = std::string_view(widget.first) == "by hand";
    EXPECT_EQ(Substitutes() > 0, by_hand) << widget.first;
    if (!by_hand) EXPECT_NE(ui_->words().find(word), std::string::npos) << widget.first;
  }
  Play([&] {
    ui_->Begin("page");
    ui_->End();
    ui_->Pictures({&picture, 1}, {});
  });
  EXPECT_EQ(Substitutes(), 0) << "pictures";
}

TEST_F(UiTest, LongestRemarkLeavesTheMiddleOfThePictureFree) {
  std::string longest;
  for (int i = 0; i < 500; ++i) longest += i % 7 == 6 ? " " : "m";
  Play([&] {
    ui_->Over({640, 360, false, 0.93f * 360});
    ui_->Begin("running", {0.605f, 0.79f, 0.38f, 0.12f, true, false});
    ui_->Remark("Ada says", longest, "R closes this");
    ui_->End();
  });
  const ImGuiWindow* window = ImGui::FindWindowByName("remark");
  ASSERT_NE(window, nullptr);
  const ImVec2 at = window->Pos, size = window->Size;
  EXPECT_LE(at.x + size.x, 0.605f * 640) << "the keys at the right stay free";
  EXPECT_LE(at.y + size.y, 0.93f * 360) << "so does the line of keys below";
  EXPECT_GE(at.y, 0.5f * 360) << "the tooth is in the middle";
}

// "Anfang" stood alone in the second line of a title.
TEST_F(UiTest, TheLinesOfATitleAreAboutAsLong) {
  const std::string title = "One two three four five six";
  int broken = 0;
  for (float width = 0.3f; width < 1; width += 0.05f) {
    float shown = 0, whole = 0, longest = 0, lines = 0;
    Play([&] {
      ui_->Begin("sign-off", {0, 0, width, 1, true});
      ui_->Title(title);
      shown = ImGui::GetItemRectSize().x;
      ImGui::PushFont(screen_->fonts().far);
      whole = ImGui::CalcTextSize(title.c_str()).x;
      longest = ImGui::CalcTextSize("three ").x;
      lines = ImGui::GetItemRectSize().y / ImGui::GetFontSize();
      ImGui::PopFont();
      ui_->End();
    });
    if (std::lround(lines) != 2) continue;
    ++broken;
    EXPECT_LT(shown, 0.5f * whole + longest) << width;
  }
  EXPECT_GT(broken, 1);
}

// Words of the page below were seen between its own.
TEST_F(UiTest, ADialogHidesThePageBelowIt) {
  Play([&] {
    ui_->BeginDialog("sign-off", "Sign");
    ui_->EndDialog();
  });
  const ImGuiWindow* dialog = ImGui::FindWindowByName("dialog");
  ASSERT_NE(dialog, nullptr);
  ASSERT_FALSE(dialog->DrawList->VtxBuffer.empty());
  EXPECT_EQ(dialog->DrawList->VtxBuffer.front().col >> IM_COL32_A_SHIFT, 255U);
}

TEST_F(UiTest, TheMouseChoosesAnyOfSeveralRowsWithTheSameTitle) {
  std::vector<int> chosen(3);
  auto page = [&] {
    ui_->Begin("list");
    for (int& row : chosen) row += ui_->Row("Class I", "of somebody", "") ? 1 : 0;
    ui_->End();
  };
  Play(page);
  ASSERT_EQ(ui_->choices().size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    ClickChoice(i);
    Play(page);
  }
  EXPECT_EQ(chosen, (std::vector<int>{1, 1, 1}));
}

TEST_F(UiTest, LettersAreTakenWithoutAFieldAndTheSpaceBarWritesAmongThem) {
  std::string typed;
  int chosen = 0;
  auto page = [&] {
    ui_->Begin("list");
    ui_->Typed(typed);
    chosen += ui_->Button("Class I") ? 1 : 0;
    ui_->End();
  };
  auto space = [&] {
    Press(render::kKeySpace);
    screen_->Inject(InputEvent::Character(' '));
    Release(render::kKeySpace);
  };
  Play(page);
  space();
  Play(page);
  EXPECT_EQ(chosen, 1) << "with nothing typed it chooses";
  EXPECT_EQ(typed, "");
  screen_->Inject(InputEvent::Character(0xe4));
  Play(page);
  space();
  screen_->Inject(InputEvent::Character('4'));
  Play(page);
  EXPECT_EQ(typed, "\u00e4 4");
  EXPECT_EQ(chosen, 1);
  for (int i = 0; i < 4; ++i) {
    Press(render::kKeyBackspace);
    Release(render::kKeyBackspace);
  }
  Play(page);
  EXPECT_EQ(typed, "") << "whole letters are taken away";
  space();
  Play(page);
  EXPECT_EQ(chosen, 2);
}

// All that a person types while a picture takes long.
TEST_F(UiTest, LettersAndASpaceWithinAFrameAreText) {
  std::string typed;
  int chosen = 0;
  auto page = [&] {
    ui_->Begin("list");
    ui_->Typed(typed);
    chosen += ui_->Button("Class I") ? 1 : 0;
    ui_->End();
  };
  const auto key = [](int code) {
    return std::vector{InputEvent::Key(code, true), InputEvent::Key(code, false)};
  };
  const std::vector<InputEvent> space = {InputEvent::Key(render::kKeySpace, true),
                                         InputEvent::Character(' '),
                                         InputEvent::Key(render::kKeySpace, false)};
  const auto together = [](std::initializer_list<std::vector<InputEvent>> parts) {
    std::vector<InputEvent> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
  };
  Play(page);
  screen_->Inject(together({{InputEvent::Character('a')}, space, {InputEvent::Character('4')}}));
  Play(page);
  EXPECT_EQ(typed, "a 4");
  EXPECT_EQ(chosen, 0);
  const auto erase = key(render::kKeyBackspace);
  screen_->Inject(together({erase, erase, erase, space}));
  Play(page);
  EXPECT_EQ(typed, "");
  EXPECT_EQ(chosen, 1) << "with nothing typed any more it chooses";
  // The space bar chooses before the letter behind it changes the list.
  screen_->Inject(together({space, {InputEvent::Character('x')}}));
  Play(page);
  EXPECT_EQ(typed, "x");
  EXPECT_EQ(chosen, 2);
}

// One page after another; what each was told.
struct TwoPages {
  bool second = false;
  int chosen = 0, left = 0, finish = 0;
  std::string typed;
  void Draw(Ui& ui) {
    if (!second) {
      ui.Begin("first");
      ui.Typed(typed);
      second = ui.Button("Next");
      ui.End();
      return;
    }
    ui.Begin("second");
    ui.Typed(typed);
    chosen += ui.Button("Start") ? 1 : 0;
    left += ui.escape() ? 1 : 0;
    finish += ui.pressed('F') ? 1 : 0;
    ui.End();
  }
};

TEST_F(UiTest, APageAnswersNoKeyThatWasPressedBeforeItWasShown) {
  const std::vector<InputEvent> behind = {InputEvent::Key(render::kKeyEnter, true),
                                          InputEvent::Key(render::kKeyEnter, false),
                                          InputEvent::Character('x'),
                                          InputEvent::Key('F', true),
                                          InputEvent::Key('F', false),
                                          InputEvent::Key(render::kKeySpace, true),
                                          InputEvent::Key(render::kKeySpace, false),
                                          InputEvent::Key(render::kKeyEscape, true)};
  const auto held = InputEvent::Key(render::kKeyLeftShift, false);
  for (int first : {int{render::kKeyEnter}, int{render::kKeySpace}, 0}) {
    TwoPages pages;
    auto page = [&] { pages.Draw(*ui_); };
    Play(page);
    Press(render::kKeyLeftShift);
    Play(page);
    std::vector<InputEvent> events;
    if (first != 0) {
      events.push_back(InputEvent::Key(first, true));
    } else {
      const Rect at = ui_->choices().at(0).at;
      events = {InputEvent::Cursor(at.x0 + 9, at.y0 + 9),
                InputEvent::Button(render::kMouseLeft, true),
                InputEvent::Button(render::kMouseLeft, false)};
    }
    events.insert(events.end(), behind.begin(), behind.end());
    events.push_back(held);
    screen_->Inject(events);
    Play(page);
    ASSERT_TRUE(pages.second) << first;
    EXPECT_EQ(pages.chosen + pages.left + pages.finish, 0) << first;
    EXPECT_EQ(pages.typed, "") << first;
    EXPECT_FALSE(screen_->key(render::kKeyLeftShift)) << "what was held is let go";
    screen_->Inject(behind);
    Play(page);
    EXPECT_EQ(pages.chosen, 1) << "Enter; behind the letter the space bar writes";
    EXPECT_EQ(pages.left, 1);
    EXPECT_EQ(pages.finish, 1);
    EXPECT_EQ(pages.typed, "x");
    Release(render::kKeyEscape);
    Release(render::kKeySpace);
  }
}

TEST_F(UiTest, AKeyThatIsHeldChoosesOnce) {
  int chosen = 0, left = 0, finish = 0;
  auto page = [&] {
    ui_->Begin("page");
    chosen += ui_->Button("Hand in") ? 1 : 0;
    left += ui_->escape() ? 1 : 0;
    finish += ui_->pressed('F') ? 1 : 0;
    ui_->End();
  };
  Play(page);
  for (int key :
       {int{render::kKeyEnter}, int{render::kKeySpace}, int{render::kKeyEscape}, int{'F'}}) {
    Press(key);
    for (int i = 0; i < 5; ++i) Repeat(key);
    Release(key);
  }
  Play(page);
  EXPECT_EQ(chosen, 2) << "Enter once and the space bar once";
  EXPECT_EQ(left, 1);
  EXPECT_EQ(finish, 1);
}

TEST_F(UiTest, AKeyThatIsHeldGoesOnMovingTheFocus) {
  std::vector<int> chosen(4);
  auto page = [&] {
    ui_->Begin("page");
    for (size_t i = 0; i < chosen.size(); ++i) {
      chosen[i] += ui_->Button("Choice " + std::to_string(i)) ? 1 : 0;
    }
    ui_->End();
  };
  Play(page);
  Press(render::kKeyDown);
  Repeat(render::kKeyDown);
  Repeat(render::kKeyDown);
  Release(render::kKeyDown);
  Press(render::kKeyEnter);
  Play(page);
  EXPECT_EQ(chosen, (std::vector<int>{0, 0, 0, 1}));
}

TEST_F(UiTest, EnterChoosesWhatLosesSomethingOnlyAfterSomebodyWentThere) {
  int lost = 0;
  auto page = [&] {
    ui_->Begin("hand-in");
    lost += ui_->Button("Hand in without the end", Ui::Look::kDanger);
    ui_->End();
  };
  Play(page);
  Press(render::kKeyEnter);
  Play(page);
  Play(page);
  EXPECT_EQ(lost, 0);
  Release(render::kKeyEnter);
  Press(render::kKeyTab);
  Play(page);
  Press(render::kKeyEnter);
  Play(page);
  Play(page);
  EXPECT_EQ(lost, 1);
}

// What a badge reader types, and xdotool: a key is up again before the next frame.
std::vector<InputEvent> Typed(std::string_view text) {
  std::vector<InputEvent> events;
  for (char c : text) {
    const int key = c == '\t' ? int{render::kKeyTab} : c == '\n' ? int{render::kKeyEnter} : 0;
    if (key == 0) {
      events.push_back(InputEvent::Character(c));
      continue;
    }
    events.push_back(InputEvent::Key(key, true));
    events.push_back(InputEvent::Key(key, false));
  }
  return events;
}

struct SignInPage {
  std::string login, password;
  std::vector<std::string> tried;
  void Draw(Ui& ui) {
    ui.Begin("sign-in");
    ui.Field("Login", login);
    bool go = ui.Field("Password", password, true);
    go |= ui.Button("Sign in");
    ui.End();
    if (!go) return;
    tried.push_back(login + "/" + password);
    password.clear();
  }
};

TEST_F(UiTest, AfterEnterTheFieldTakesTheNextWord) {
  SignInPage page;
  auto draw = [&] { page.Draw(*ui_); };
  Play(draw);
  for (std::string_view word : {"ada", "\t", "wrong", "\n", "right", "\n"}) {
    screen_->Inject(Typed(word));
    Play(draw);
    Play(draw);
  }
  EXPECT_EQ(page.tried, (std::vector<std::string>{"ada/wrong", "ada/right"}));
}

TEST_F(UiTest, AShortEnterCountsInAFieldThatWasClicked) {
  SignInPage page;
  auto draw = [&] { page.Draw(*ui_); };
  Play(draw);
  for (int i = 0; i < 3; ++i) {
    ClickChoice(1);
    screen_->Inject(Typed("secret\n"));
    Play(draw);
    Play(draw);
  }
  EXPECT_EQ(page.tried, (std::vector<std::string>{"/secret", "/secret", "/secret"}));
}

TEST_F(UiTest, ABadgeReaderSignsInWithinAFrame) {
  SignInPage page;
  auto draw = [&] { page.Draw(*ui_); };
  Play(draw);
  screen_->Inject(Typed("ada\tsecret\n"));
  for (int i = 0; i < 4; ++i) Play(draw);
  EXPECT_EQ(page.tried, (std::vector<std::string>{"ada/secret"}));
}

// Where a picture takes longer than a key is held, Dear ImGui would take Enter for held down: a
// second Enter in the next field, which then loses a letter.
TEST_F(UiTest, SlowPicturesLoseNoLetter) {
  // As if every frame took longer than both.
  ImGui::GetIO().KeyRepeatDelay = ImGui::GetIO().KeyRepeatRate = 1e-6f;
  std::string pin, again, kept;
  int entered = 0;
  auto page = [&] {
    ui_->Begin("reserve");
    if (ui_->Field("PIN", pin, true)) ui_->Focus("Again");
    const bool go = ui_->Field("Again", again, true);
    ui_->End();
    if (!go) return;
    ++entered;
    kept = again;
  };
  Play(page);
  screen_->Inject(Typed("804217\n804217\n"));
  for (int i = 0; i < 4; ++i) Play(page);
  EXPECT_EQ(kept, "804217");
  EXPECT_EQ(entered, 1) << "Enter counts in the field in which it was pressed";
}

TEST_F(UiTest, NoButtonLeavesThePage) {
  auto page = [&] {
    ui_->Begin("page");
    for (const char* label :
         {"Weiter schneiden", "Aufheben", "Ger\u00e4te suchen", "Zur\u00fcck"}) {
      (void)ui_->Button(label);
      ui_->SameLine();
    }
    ui_->End();
  };
  Play(page);
  ASSERT_EQ(ui_->choices().size(), 4u);
  EXPECT_EQ(ui_->choices()[0].at.y0, ui_->choices()[1].at.y0) << "there is room for two";
  for (const Choice& choice : ui_->choices()) EXPECT_LE(choice.at.x1, 0.9f * 640) << choice.label;
}

// On a result at 900 x 600 it was cut off: "An diesem Zahn weiterüben".
TEST_F(UiTest, AButtonThatIsTooLongHasSmallerLetters) {
  auto page = [&] {
    ui_->Begin("page", {0.02f, 0.04f, 0.34f, 0.5f, false});
    (void)ui_->Button("Continue");
    (void)ui_->Button("Continue this cut here");
    ui_->End();
  };
  Play(page);
  ASSERT_EQ(ui_->choices().size(), 2u);
  for (const Choice& choice : ui_->choices()) EXPECT_LE(choice.at.x1, 0.36f * 640) << choice.label;
  auto height = [&](size_t i) { return ui_->choices()[i].at.y1 - ui_->choices()[i].at.y0; };
  EXPECT_LT(height(1), height(0));
}

// The languages of the first page stood to the right of its column.
TEST_F(UiTest, AButtonThatIsMissingMovesNoLaterOne) {
  auto page = [&] {
    ui_->Begin("page");
    (void)ui_->Button("Sign in");
    ui_->SameLine();
    ui_->Gap();
    (void)ui_->Button("English");
    ui_->SameLine();
    ui_->Text("Wrong password");
    // Where one was to be first, and is missing.
    ui_->SameLine();
    (void)ui_->Button("Deutsch");
    ui_->End();
  };
  Play(page);
  ASSERT_EQ(ui_->choices().size(), 3u);
  for (const Choice& choice : ui_->choices()) {
    EXPECT_EQ(choice.at.x0, ui_->choices()[0].at.x0) << choice.label;
  }
}

TEST_F(UiTest, ArrowsMoveAmongCardsAsTheyAreSeen) {
  const std::vector<Card> cards(5, {"Crown", {"of a tooth"}, "", {}});
  std::vector<size_t> chosen;
  auto page = [&] {
    ui_->Begin("list");
    if (const auto card = ui_->Cards(cards)) chosen.push_back(*card);
    ui_->End();
  };
  Play(page);
  for (int key : {render::kKeyDown, render::kKeyRight, render::kKeyUp}) {
    Press(key);
    Release(key);
    Press(render::kKeyEnter);
    Release(render::kKeyEnter);
    Play(page);
  }
  EXPECT_EQ(chosen, (std::vector<size_t>{2, 3, 1}));
}

TEST_F(UiTest, AScriptClicksWhatIsBelowTheFold) {
  test::TempFolder folder;
  std::ofstream(folder.path() / "script") << "click Exercise 18\nclick Exercise 3\n";
  Script script = *Script::Read(folder.path() / "script");
  std::vector<Card> cards;
  for (int i = 0; i < 19; ++i) {
    cards.push_back({"Exercise " + std::to_string(i) + ".", {"any number of attempts"}, "", {}});
  }
  std::vector<size_t> chosen;
  int after = 3;
  for (int frame = 0; frame < 300 && after > 0; ++frame) {
    (void)screen_->Begin();
    ui_->Begin("exercises");
    ui_->BeginList("exercises");
    if (const auto card = ui_->Cards(cards)) chosen.push_back(*card);
    ui_->EndList();
    (void)ui_->Button("Sign out");
    ui_->End();
    ui_->EndFrame();
    screen_->End();
    if (script.playing())
      (void)script.Step(*screen_, *ui_, nullptr);
    else if (!screen_->injecting())
      --after;
  }
  EXPECT_EQ(chosen, (std::vector<size_t>{18, 3}));
  EXPECT_LE(ui_->choices().back().at.y1, 0.93f * 360) << "what follows the list stays on the page";
}

TEST_F(UiTest, ThePedalChoosesNothingInADialogOverAnAttempt) {
  int chosen = 0;
  Ui::Space space = Ui::Space::kIsThePedal;
  auto page = [&] {
    ui_->Begin("running");
    ui_->End();
    ui_->BeginDialog("finish", "Finish?", space);
    chosen += ui_->Button("Hand in") ? 1 : 0;
    ui_->EndDialog();
  };
  auto space_bar = [&] {
    Press(render::kKeySpace);
    Release(render::kKeySpace);
    Play(page);
  };
  Play(page);
  space_bar();
  EXPECT_EQ(chosen, 0);
  Press(render::kKeyEnter);
  Release(render::kKeyEnter);
  Play(page);
  EXPECT_EQ(chosen, 1);
  space = Ui::Space::kChooses;
  Play(page);
  space_bar();
  EXPECT_EQ(chosen, 2) << "in other dialogs it chooses";
}

}  // namespace
}  // namespace enamel::station::desk
