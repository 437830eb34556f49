#include "station/render/screen.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>
// epoxy must come before GLFW, which would otherwise include its own OpenGL headers.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "station/render/gl_objects.h"
#include "station/render/keyboard.h"
#include "station/render/monitors.h"
#include "station/render/png_file.h"
#include "station/render/shaped_text.h"

namespace enamel::station::render {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kFrameTime = std::chrono::milliseconds(16);
// Between frames of a page that rests: no one notices a tenth of a second where nothing was touched,
// and Dear ImGui's text cursor blinks in steps of 0.4 s.
constexpr auto kRest = std::chrono::milliseconds(100);
// A page's sizes settle within so many frames.
constexpr int kSettleFrames = 4;
constexpr int kButtons = 3;
// A field that Tab or Enter leads to takes letters from the third frame on.
constexpr int kFocusFrames = 3;
// Frames in which the window system may still put the cursor elsewhere: its requests and events pass
// each other.
constexpr int kPlacedFrames = 3;
// The largest step of a hand in one event, as a share of the window's height. A hand that takes the
// cursor across the window into a target half as far wide needs 0.13 s (Card, English and Burr 1978:
// 0.1 s for each bit of distance by target). Its top speed is 1.9 times its mean (Flash and Hogan
// 1985). A slow mouse, which reports 125 times a second, then moves by 0.12 of the height in a
// report. Twice that is no hand's.
constexpr double kLargestStep = 0.25;

static_assert(Keyboard::kPlaces == GLFW_KEY_LAST + 1);
static_assert(kKeySpace == GLFW_KEY_SPACE && kKeyEscape == GLFW_KEY_ESCAPE &&
              kKeyEnter == GLFW_KEY_ENTER && kKeyTab == GLFW_KEY_TAB &&
              kKeyBackspace == GLFW_KEY_BACKSPACE && kKeyRight == GLFW_KEY_RIGHT &&
              kKeyLeft == GLFW_KEY_LEFT && kKeyDown == GLFW_KEY_DOWN && kKeyUp == GLFW_KEY_UP &&
              kKeyF1 == GLFW_KEY_F1 && kKeyPadEnter == GLFW_KEY_KP_ENTER &&
              kKeyLeftShift == GLFW_KEY_LEFT_SHIFT && kKeyRightShift == GLFW_KEY_RIGHT_SHIFT &&
              kKeyLeftControl == GLFW_KEY_LEFT_CONTROL &&
              kKeyRightControl == GLFW_KEY_RIGHT_CONTROL);
static_assert(kMouseLeft == GLFW_MOUSE_BUTTON_LEFT && kMouseRight == GLFW_MOUSE_BUTTON_RIGHT &&
              kMouseMiddle == GLFW_MOUSE_BUTTON_MIDDLE && kModShift == GLFW_MOD_SHIFT);

std::string LastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

// GLFW calls back without saying for whom: it is one per process, as is the window.
bool monitors_changed = false;

class GlfwWindow {
 public:
  explicit GlfwWindow(const ScreenOptions& options) : options_(options) {
    // Errors are read by LastGlfwError and become exceptions; GLFW prints nothing.
    glfwSetErrorCallback(nullptr);
    if (!glfwInit()) throw std::runtime_error(LastGlfwError());
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, options.visible ? GLFW_TRUE : GLFW_FALSE);
    // Else a full-screen window vanishes with the keyboard's focus, while an attempt's clock runs.
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
    Open();
    if (!window_) {
      std::string reason = LastGlfwError();
      glfwTerminate();
      throw std::runtime_error(reason);
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(options.paced ? 1 : 0);
  }
  ~GlfwWindow() {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;
  GLFWwindow* get() const { return window_; }
  // Size of a pixel of the monitor that the window is on.
  double pixel_mm() const { return pixel_mm_; }

  // Where `monitor` says, or on the primary one: when monitors come or go. GLFW makes a window of
  // what was full screen on a monitor that has gone.
  void Place() {
    GLFWmonitor* monitor = Choose();
    const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
    if (mode == nullptr) return;
    if (options_.full_screen) {
      if (glfwGetWindowMonitor(window_) == monitor) return;
      return glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height,
                                  mode->refreshRate);
    }
    if (options_.monitor.empty()) return;
    int x = 0, y = 0, width = 0, height = 0;
    glfwGetMonitorPos(monitor, &x, &y);
    glfwGetWindowSize(window_, &width, &height);
    // Not above or left of it, where nobody could take hold of it.
    glfwSetWindowPos(window_, x + std::max(0, (mode->width - width) / 2),
                     y + std::max(0, (mode->height - height) / 2));
  }

 private:
  void Open() {
    GLFWmonitor* monitor = Choose();
    if (!options_.full_screen) monitor = nullptr;
    const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
    window_ =
        glfwCreateWindow(mode != nullptr ? mode->width : options_.width_px,
                         mode != nullptr ? mode->height : options_.height_px,
                         options_.title.c_str(), mode != nullptr ? monitor : nullptr, nullptr);
    if (window_ != nullptr) Place();
  }

  // Null without any monitor.
  GLFWmonitor* Choose() {
    int count = 0;
    GLFWmonitor** all = glfwGetMonitors(&count);
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.emplace_back(glfwGetMonitorName(all[i]));
    const auto found = options_.monitor.empty() && count > 0 ? std::optional<size_t>(0)
                                                             : FindMonitor(names, options_.monitor);
    const std::string missing = found ? "" : MissingMonitorText(names, options_.monitor);
    if (missing != std::exchange(missing_, missing) && !missing.empty() &&
        options_.monitor_missing) {
      options_.monitor_missing(missing);
    }
    GLFWmonitor* monitor = count > 0 ? all[found.value_or(0)] : nullptr;
    const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
    if (mode != nullptr) {
      int width_mm = 0, height_mm = 0;
      glfwGetMonitorPhysicalSize(monitor, &width_mm, &height_mm);
      pixel_mm_ = PixelOf_mm(mode->width, mode->height, width_mm, height_mm);
    }
    if (options_.pixel_mm > 0) pixel_mm_ = options_.pixel_mm;
    return monitor;
  }

  const ScreenOptions options_;
  std::string missing_;  // as said last
  double pixel_mm_ = kReferencePixel_mm;
  GLFWwindow* window_ = nullptr;
};

bool IsSoftware(std::string_view renderer) {
  // Mesa's names for software rendering.
  return renderer.find("llvmpipe") != renderer.npos || renderer.find("softpipe") != renderer.npos;
}

ImVec4 Shade(int r, int g, int b, float a = 1) {
  return {static_cast<float>(r) / 255, static_cast<float>(g) / 255, static_cast<float>(b) / 255, a};
}

void SetStyle(float scale) {
  ImGuiStyle style;
  ImGui::StyleColorsDark(&style);
  style.WindowRounding = style.FrameRounding = style.ScrollbarRounding = 12;
  style.WindowPadding = {24, 20};
  style.FramePadding = {18, 10};
  style.ItemSpacing = {14, 10};
  style.ScrollbarSize = 22;
  style.WindowBorderSize = 0;
  style.ScaleAllSizes(scale);
  style.Colors[ImGuiCol_WindowBg] = Shade(15, 17, 20, 0.86f);
  style.Colors[ImGuiCol_TextDisabled] = Shade(176, 184, 194);
  style.Colors[ImGuiCol_FrameBg] = Shade(44, 50, 58);
  ImGui::GetStyle() = style;
}

}  // namespace

class Screen::Impl {
 public:
  explicit Impl(const ScreenOptions& options) : paced_(options.paced), glfw_(options) {
    auto text = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    renderer_ = text ? text : "unknown";
    software_ = IsSoftware(renderer_);
    ListenToInput();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    // Dear ImGui would write both into the current folder.
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    // Without its own callbacks: Take receives all input, a person's and a script's alike.
    ImGui_ImplGlfw_InitForOpenGL(glfw_.get(), false);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    // The pages move the focus and handle leaving.
    for (int key : {ImGuiKey_Tab, ImGuiKey_Escape}) io.KeyMap[key] = -1;
    Measure();
  }

  ~Impl() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }

  bool Begin() {
    events_.clear();
    ++frame_;
    awake_ = false;
    moved_x_ = moved_y_ = 0;
    left_ = false;
    Wait();
    began_ = Clock::now();
    glfwPollEvents();
    if (std::exchange(monitors_changed, false)) glfw_.Place();
    if (!injected_.empty()) {
      // One step a frame: spreads a script's input over frames, like a hand's.
      for (const InputEvent& event : injected_.front()) Queue(event);
      injected_.pop_front();
    }
    TakePending();
    if (!events_.empty()) same_frames_ = 0;
    if (placed_frames_ > 0) --placed_frames_;
    Measure();
    shaped_.NextFrame();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    // All input comes through Take, also a script's.
    ImGuiIO& io = ImGui::GetIO();
    // Dear ImGui's value for "no mouse".
    io.MousePos = captured_ ? ImVec2{-FLT_MAX, -FLT_MAX}
                            : ImVec2{static_cast<float>(cursor_x_), static_cast<float>(cursor_y_)};
    for (int i = 0; i < kButtons; ++i) {
      io.MouseDown[i] = held_[static_cast<size_t>(i)] || clicked_[static_cast<size_t>(i)];
    }
    clicked_.reset();
    // A key that came and went between two frames is down for one.
    for (size_t key = 0; key < keys_.size(); ++key) io.KeysDown[key] = keys_[key] || tapped_[key];
    // Held, Enter would count again in the field that it led to, which then loses a letter.
    for (const size_t key : {kKeyEnter, kKeyPadEnter}) io.KeysDown[key] = tapped_[key];
    tapped_.reset();
    ImGui::NewFrame();
    return !glfwWindowShouldClose(glfw_.get());
  }

  // Through our own target: the contents of a window's back buffer are undefined after a swap, and
  // a screenshot reads the picture that was shown.
  void Show(const Target& picture) {
    glDisable(GL_SCISSOR_TEST);
    picture.CopyColourTo(*shown_);
    has_picture_ = true;
  }

  void End() {
    ImGui::Render();
    if (LooksTheSame()) {
      drawing_s_ = std::chrono::duration<double>(Clock::now() - began_).count();
      next_ = began_ + kFrameTime;
      return;
    }
    ++drawn_;
    glDisable(GL_SCISSOR_TEST);
    shown_->Bind();
    if (!has_picture_) {
      glClearColor(0.075f, 0.085f, 0.10f, 1);
      glClear(GL_COLOR_BUFFER_BIT);
    }
    has_picture_ = false;
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glBindFramebuffer(GL_READ_FRAMEBUFFER, shown_->name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
    // Otherwise drawing is only queued, and its time is not measured. A graphics card is not waited
    // for.
    if (software_ || !paced_) glFinish();
    auto end = Clock::now();
    drawing_s_ = std::chrono::duration<double>(end - began_).count();
    // With software rendering the tick needs the processor too: pause half as long as drawing took.
    next_ = std::max(began_ + kFrameTime, software_ ? end + (end - began_) / 2 : end);
    glfwSwapBuffers(glfw_.get());
  }

  Status WriteScreenshot(const std::string& path) { return WritePng(path, shown_->Read()); }

  // The cursor jumps when it is captured and released; the person did not move it.
  void Capture(bool capture) {
    if (capture == captured_) return;
    captured_ = capture;
    Place();
    glfwSetInputMode(glfw_.get(), GLFW_CURSOR, capture ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
    glfwGetCursorPos(glfw_.get(), &cursor_x_, &cursor_y_);
    moved_x_ = moved_y_ = 0;
  }

  void DropWaiting() {
    std::erase_if(pending_, [&](const Waiting& waiting) {
      const InputEvent& event = waiting.event;
      const bool chooses = event.pressed && (event.kind == InputEvent::Kind::kKey ||
                                             event.kind == InputEvent::Kind::kCharacter ||
                                             event.kind == InputEvent::Kind::kButton);
      return chooses && waiting.frame < frame_;
    });
  }

  GLFWwindow* window() const { return glfw_.get(); }

  std::vector<InputEvent> events_;
  std::deque<std::vector<InputEvent>> injected_;
  struct Waiting {
    InputEvent event;
    uint64_t frame;  // in which it came
  };
  std::deque<Waiting> pending_;  // not taken yet
  double cursor_x_ = 0, cursor_y_ = 0, moved_x_ = 0, moved_y_ = 0;
  std::bitset<kButtons> held_;
  std::array<int, GLFW_KEY_LAST + 1> keys_{};  // by code: its place while it is held; 0: it is not
  Keyboard keyboard_{[](int place) { return glfwGetKeyName(place, 0); }};
  int width_ = 0, height_ = 0;
  double pixel_mm_ = 0;
  Fonts fonts_;
  language::Language language_ = language::Language::kEnglish;
  bool respell_ = false;  // the language has changed
  std::string renderer_;
  bool software_ = false, captured_ = false;
  bool away_ = false, left_ = false;  // another has the keyboard; it has had it in this frame
  double drawing_s_ = 0;
  uint64_t frame_ = 0, drawn_ = 0;
  bool awake_ = false;  // this frame asks for another soon

 private:
  static Impl& Of(GLFWwindow* window) {
    return *static_cast<Impl*>(glfwGetWindowUserPointer(window));
  }

  // A script's letter is where a US keyboard has it.
  static int PlaceOf(const InputEvent& event) {
    return event.place != 0 ? event.place : event.code;
  }

  void ListenToInput() {
    GLFWwindow* window = glfw_.get();
    glfwSetWindowUserPointer(window, this);
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
      Impl& screen = Of(w);
      screen.Queue(
          screen.keyboard_.Event(key, action != GLFW_RELEASE, mods, action == GLFW_REPEAT));
    });
    glfwSetCharCallback(window, [](GLFWwindow* w, unsigned c) {
      Of(w).Queue(InputEvent::Character(static_cast<int>(c)));
    });
    glfwSetScrollCallback(
        window, [](GLFWwindow* w, double, double dy) { Of(w).Queue(InputEvent::Wheel(dy)); });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
      Of(w).Queue(InputEvent::Button(button, action == GLFW_PRESS));
    });
    glfwSetCursorPosCallback(
        window, [](GLFWwindow* w, double x, double y) { Of(w).Queue(InputEvent::Cursor(x, y)); });
    glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int focused) {
      Of(w).Queue(InputEvent::Focus(focused == GLFW_TRUE));
    });
    glfwSetWindowIconifyCallback(window, [](GLFWwindow* w, int iconified) {
      // Back from there it may get no new focus: without a window manager it never lost it.
      const bool here = iconified == GLFW_FALSE && glfwGetWindowAttrib(w, GLFW_FOCUSED) != 0;
      if (here || iconified == GLFW_TRUE) Of(w).Queue(InputEvent::Focus(here));
    });
    // A captured cursor's places are the motion since its capture; where it enters is a place in the
    // window, and GLFW reports both alike.
    glfwSetCursorEnterCallback(window, [](GLFWwindow* w, int entered) {
      if (entered == GLFW_TRUE) Of(w).Queue(InputEvent::Placed());
    });
    glfwSetWindowPosCallback(window,
                             [](GLFWwindow* w, int, int) { Of(w).Queue(InputEvent::Placed()); });
    // It was covered, or has another size.
    glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { Of(w).exposed_ = true; });
    glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { Of(w).exposed_ = true; });
    monitors_changed = false;
    glfwSetMonitorCallback([](GLFWmonitor*, int) { monitors_changed = true; });
  }

  // Nothing waits before the loss of the keyboard: the bur must stop at once, and what was pressed
  // before it must not be pressed afterwards.
  void Queue(const InputEvent& event) {
    if (event.kind == InputEvent::Kind::kFocus && !event.pressed) {
      pending_.clear();
      settling_ = 0;
    }
    pending_.push_back({event, frame_});
  }

  void TakePending() {
    if (settling_ > 0 && --settling_ > 0) return;
    while (!pending_.empty() && settling_ == 0) {
      const InputEvent event = pending_.front().event;
      pending_.pop_front();
      Take(event);
      settling_ = FramesBehind(event);
      // The space bar's own letter comes with it.
      const bool space = settling_ > 0 && event.code == kKeySpace && !pending_.empty();
      if (space && pending_.front().event.kind == InputEvent::Kind::kCharacter) {
        Take(pending_.front().event);
        pending_.pop_front();
      }
    }
  }

  // How long what comes behind this waits. A badge reader writes login, Tab, password and Enter within
  // a frame: the field that Tab leads to has the focus later. Other keys and clicks that choose
  // something may show another page in the next frame.
  int FramesBehind(const InputEvent& event) const {
    // A captured mouse chooses nothing, and the space bar is the pedal.
    if (event.kind == InputEvent::Kind::kButton) return !event.pressed && !captured_ ? 1 : 0;
    if (event.kind != InputEvent::Kind::kKey || !event.pressed) return 0;
    if (event.code == kKeyTab || event.code == kKeyEnter || event.code == kKeyPadEnter) {
      return kFocusFrames;
    }
    return event.code == kKeyEscape || (event.code == kKeySpace && !captured_) ? 1 : 0;
  }

  void Take(const InputEvent& event) {
    events_.push_back(event);
    GLFWwindow* window = glfw_.get();
    switch (event.kind) {
      case InputEvent::Kind::kKey:
        if (event.code < 0 || event.code > GLFW_KEY_LAST) return;
        if (event.pressed && !event.repeat) tapped_[static_cast<size_t>(event.code)] = true;
        keys_[static_cast<size_t>(event.code)] = event.pressed ? PlaceOf(event) : 0;
        // It asks for what is printed there itself.
        return ImGui_ImplGlfw_KeyCallback(window, PlaceOf(event), 0,
                                          event.pressed ? GLFW_PRESS : GLFW_RELEASE, event.mods);
      case InputEvent::Kind::kCharacter:
        return ImGui_ImplGlfw_CharCallback(window, static_cast<unsigned>(event.code));
      case InputEvent::Kind::kWheel:
        return ImGui_ImplGlfw_ScrollCallback(window, 0, event.y);
      case InputEvent::Kind::kCursor:
        return MoveTo(event.x, event.y);
      case InputEvent::Kind::kButton:
        if (event.code < 0 || event.code >= kButtons) return;
        held_[static_cast<size_t>(event.code)] = event.pressed;
        if (event.pressed) clicked_[static_cast<size_t>(event.code)] = true;
        // Where there is a window manager it has done so already.
        if (event.pressed && away_) glfwFocusWindow(window);
        return;
      case InputEvent::Kind::kFocus:
        away_ = !event.pressed;
        left_ |= away_;
        if (away_) LetGo();
        return Place();
      case InputEvent::Kind::kPlaced:
        placed_ = true;
        return;
    }
  }

  // The next place of the cursor is the window system's choice, and so is any in these frames.
  void Place() {
    placed_ = true;
    placed_frames_ = kPlacedFrames;
  }

  void MoveTo(double x, double y) {
    const double dx = x - std::exchange(cursor_x_, x), dy = y - std::exchange(cursor_y_, y);
    const bool placed = std::exchange(placed_, false) || placed_frames_ > 0 || away_;
    if (placed || (captured_ && std::hypot(dx, dy) > kLargestStep * height_)) return;
    moved_x_ += dx;
    moved_y_ += dy;
  }

  // Another window gets what is pressed from now on, and every release.
  void LetGo() {
    for (size_t key = 0; key < keys_.size(); ++key) {
      if (keys_[key] != 0) ImGui_ImplGlfw_KeyCallback(glfw_.get(), keys_[key], 0, GLFW_RELEASE, 0);
    }
    keys_.fill(0);
    tapped_.reset();
    held_.reset();
    clicked_.reset();
  }

  void Wait() {
    while (paced_) {
      const bool rests = same_frames_ >= kSettleFrames && !Stirs();
      const Clock::time_point until = rests ? std::max(next_, began_ + kRest) : next_;
      std::chrono::duration<double> left = until - Clock::now();
      if (left.count() <= 0) return;
      // Returns with every event. The callbacks have handled it by then, and the wait continues.
      glfwWaitEventsTimeout(left.count());
    }
  }

  // Something is to be shown, or somebody holds something whose repeats Dear ImGui counts in frames.
  bool Stirs() const {
    return !pending_.empty() || !injected_.empty() || exposed_ || monitors_changed || held_.any() ||
           std::ranges::any_of(keys_, [](int place) { return place != 0; }) ||
           glfwWindowShouldClose(glfw_.get());
  }

  // This frame has the same triangles, letters and textures as the last one that was drawn.
  // A picture below it may have changed.
  bool LooksTheSame() {
    std::vector<char> looks;
    if (paced_ && !has_picture_) {
      const auto add = [&](const auto& buffer) {
        const auto* from = reinterpret_cast<const char*>(buffer.Data);
        looks.insert(looks.end(), from, from + buffer.size_in_bytes());
      };
      const ImDrawData& drawn = *ImGui::GetDrawData();
      for (int i = 0; i < drawn.CmdListsCount; ++i) {
        add(drawn.CmdLists[i]->CmdBuffer);
        add(drawn.CmdLists[i]->IdxBuffer);
        add(drawn.CmdLists[i]->VtxBuffer);
      }
    }
    // OpenGL may give a new picture the name of a deleted one.
    if (std::exchange(shaped_made_, shaped_.made()) != shaped_.made()) exposed_ = true;
    const bool exposed = std::exchange(exposed_, has_picture_ || !paced_);
    const bool same = !exposed && looks == looks_;
    looks_ = std::move(looks);
    same_frames_ = same && !awake_ ? same_frames_ + 1 : 0;
    return same;
  }

  // After a change of the window's size or language: fonts and picture in the new one.
  void Measure() {
    int width = 0, height = 0;
    glfwGetFramebufferSize(glfw_.get(), &width, &height);
    if (width == 0 || height == 0) return;  // minimised
    const double pixel_mm = glfw_.pixel_mm();
    if (width == width_ && height == height_ && pixel_mm == pixel_mm_ && !respell_) return;
    respell_ = false;
    pixel_mm_ = pixel_mm;
    exposed_ = true;
    if (width != width_ || height != height_) Place();
    width_ = width;
    height_ = height;
    shown_ = std::make_unique<Target>(width, height, std::initializer_list<GLenum>{GL_RGBA8}, false,
                                      GL_NEAREST);
    fonts_ = MakeFonts(LettersFor(width, height, pixel_mm), language_);
    fonts_.shaped = &shaped_;
    SetStyle(fonts_.scale);
    // Fonts are pixels of one size: another needs new ones.
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
  }

  const bool paced_;
  GlfwWindow glfw_;
  // Pressed since the last frame, even if let go already.
  std::bitset<kButtons> clicked_;
  std::bitset<GLFW_KEY_LAST + 1> tapped_;
  bool placed_ = false;    // the next place of the cursor is no hand's
  int placed_frames_ = 0;  // nor is any in so many frames
  int settling_ = 0;       // frames until the input that waits is taken
  std::unique_ptr<Target> shown_;
  bool has_picture_ = false;  // this frame
  bool exposed_ = true;       // to be drawn, whatever it looks like
  std::vector<char> looks_;   // of the last frame
  int same_frames_ = 0;       // without input, that looked the same
  ShapedTexts shaped_;
  uint64_t shaped_made_ = 0;  // as of the last frame
  Clock::time_point began_{}, next_{};
};

Screen::Screen(const ScreenOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Screen::~Screen() = default;

bool Screen::Begin() { return impl_->Begin(); }
void Screen::StayAwake() { impl_->awake_ = true; }
void Screen::Show(const Target& picture) { impl_->Show(picture); }
void Screen::End() { impl_->End(); }
void Screen::Speak(language::Language language) {
  impl_->respell_ |= language != impl_->language_;
  impl_->language_ = language;
}
void Screen::CancelClose() { glfwSetWindowShouldClose(impl_->window(), GLFW_FALSE); }
void Screen::Close() { glfwSetWindowShouldClose(impl_->window(), GLFW_TRUE); }
std::span<const InputEvent> Screen::events() const { return impl_->events_; }
void Screen::Inject(std::vector<InputEvent> events) {
  impl_->injected_.push_back(std::move(events));
}
void Screen::DropWaiting() { impl_->DropWaiting(); }
void Screen::CaptureCursor(bool capture) { impl_->Capture(capture); }
bool Screen::injecting() const { return !impl_->injected_.empty() || !impl_->pending_.empty(); }
double Screen::cursor_x() const { return impl_->cursor_x_; }
double Screen::cursor_y() const { return impl_->cursor_y_; }
double Screen::moved_x() const { return impl_->moved_x_; }
double Screen::moved_y() const { return impl_->moved_y_; }
bool Screen::away() const { return impl_->away_ || impl_->left_; }
bool Screen::button(int button) const {
  return button >= 0 && button < kButtons && impl_->held_[static_cast<size_t>(button)];
}
bool Screen::key(int key) const {
  return key >= 0 && key <= GLFW_KEY_LAST && impl_->keys_[static_cast<size_t>(key)] != 0;
}
int Screen::KeyAt(int place) const { return impl_->keyboard_.At(place); }
int Screen::width() const { return impl_->width_; }
int Screen::height() const { return impl_->height_; }
const Fonts& Screen::fonts() const { return impl_->fonts_; }
bool Screen::draws_in_software() const { return impl_->software_; }
const std::string& Screen::renderer() const { return impl_->renderer_; }
double Screen::drawing_s() const { return impl_->drawing_s_; }
uint64_t Screen::drawn() const { return impl_->drawn_; }
Status Screen::WriteScreenshot(const std::string& path) { return impl_->WriteScreenshot(path); }

}  // namespace enamel::station::render
