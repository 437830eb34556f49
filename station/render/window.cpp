#include "station/render/window.h"

#include <epoxy/gl.h>
// epoxy must come before GLFW, which would otherwise bring OpenGL headers of its own.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

#include "station/render/brick_feed.h"
#include "station/render/camera.h"
#include "station/render/latest.h"
#include "station/render/mesher.h"
#include "station/render/panel.h"
#include "station/render/picture.h"
#include "station/render/png_file.h"

namespace enamel::station::render {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kRingBricks = 1024;  // about 1 MB
constexpr auto kMeshLimit = std::chrono::seconds(30);
constexpr double kGhostFrom_m = 50e-6;  // apart by less, hand and bur look the same
constexpr float kArrowFullScale_mm = 5;
constexpr float kSpinPerFrame = 0.37f;  // for the eye: not the true speed

std::string LastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

// GLFW is one per process, as is the window.
class GlfwWindow {
 public:
  explicit GlfwWindow(const WindowOptions& options) {
    glfwSetErrorCallback(nullptr);
    if (!glfwInit()) throw std::runtime_error(LastGlfwError());
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, options.visible ? GLFW_TRUE : GLFW_FALSE);
    window_ = glfwCreateWindow(options.width_px, options.height_px, options.title.c_str(), nullptr,
                               nullptr);
    if (!window_) {
      std::string reason = LastGlfwError();
      glfwTerminate();
      throw std::runtime_error(reason);
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
  }
  ~GlfwWindow() {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;
  GLFWwindow* get() const { return window_; }

 private:
  GLFWwindow* window_ = nullptr;
};

bool DrawsInSoftware() {
  auto text = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  std::string_view renderer = text ? text : "";
  return renderer.find("llvmpipe") != renderer.npos || renderer.find("softpipe") != renderer.npos;
}

// Half the larger of length and width of what is there, with a margin.
float RadiusOf(const cutting::Volume& volume) {
  const cutting::GridSpec& spec = volume.spec();
  ivec3 lo = spec.bricks, hi(-1);
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!volume.IsStored(b)) continue;
    ivec3 at(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
             b / (spec.bricks.x * spec.bricks.y));
    lo = glm::min(lo, at);
    hi = glm::max(hi, at);
  }
  int bricks = std::max({hi.x - lo.x, hi.y - lo.y, 0}) + 1;
  return 0.62f * static_cast<float>(bricks * cutting::kBrickSide * spec.voxel_m() * 1000);
}

glm::mat4 FromPose(const cutting::Pose& pose) {
  glm::mat4 m(glm::mat3(pose.orientation.Matrix()));
  m[3] = glm::vec4(glm::vec3(pose.tip_m * 1000.0), 1);
  return m;
}

}  // namespace

class Window::Impl {
 public:
  Impl(const WindowOptions& options, const cutting::Volume& initial)
      : options_(options),
        glfw_(options),
        software_(DrawsInSoftware()),
        camera_(glm::vec3(options.focus_m * 1000.0),
                options.view_radius_m > 0 ? static_cast<float>(options.view_radius_m * 1000)
                                          : RadiusOf(initial)),
        feed_(initial.spec().brick_count(), kRingBricks),
        mesher_(initial, feed_),
        picture_(options.bur, mesher_.group_count()) {
    camera_.SetView(options.view);
    ListenToInput();
    panel_.emplace(glfw_.get());  // after the callbacks, which it passes on
  }

  void Publish(const FrameState& state) noexcept { latest_.Write(state); }

  void PublishBricks(const cutting::Volume& volume, std::span<const int32_t> touched) noexcept {
    feed_.Mark(touched);
    feed_.Send(volume, kBricksPerTick);
  }

  void FlushBricks(const cutting::Volume& volume) {
    auto until = Clock::now() + kMeshLimit;
    while (feed_.dirty_count() > 0 && Clock::now() < until) {
      if (feed_.Send(volume, kRingBricks) == 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    mesher_.WaitIdle(kMeshLimit);
  }

  bool PumpOnce() {
    for (;;) {
      std::chrono::duration<double> left = next_frame_ - Clock::now();
      if (left.count() <= 0) break;
      glfwWaitEventsTimeout(left.count());
    }
    auto start = Clock::now();
    glfwPollEvents();
    DrawFrame(software_ ? 1 : 2);
    // At most 60 frames a second. Where the processor draws, the tick needs it too: pause as long
    // as drawing took.
    auto end = Clock::now();
    next_frame_ =
        std::max(start + std::chrono::milliseconds(16), software_ ? end + (end - start) : end);
    return !glfwWindowShouldClose(glfw_.get());
  }

  Status WriteScreenshot(const std::string& path) {
    if (!mesher_.WaitIdle(kMeshLimit)) {
      return Status(Code::kUnavailable,
                    "expected the surface within 30 s, found it still being computed; "
                    "the machine is too busy or the voxels are too small",
                    "screenshot");
    }
    glfwPollEvents();
    // Twice: the panel takes the size its text asks for one frame later.
    DrawFrame(1);
    DrawFrame(2);
    const Target& result = picture_.result();
    std::vector<uint8_t> rgb(static_cast<size_t>(result.width()) * result.height() * 3);
    result.Bind();
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, result.width(), result.height(), GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
    return WritePng(path, rgb, result.width(), result.height());
  }

  void SetView(View view) { camera_.SetView(view); }

 private:
  static Impl& Of(GLFWwindow* window) {
    return *static_cast<Impl*>(glfwGetWindowUserPointer(window));
  }

  void ListenToInput() {
    GLFWwindow* window = glfw_.get();
    glfwSetWindowUserPointer(window, this);
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
      if (action == GLFW_PRESS) Of(w).OnKey(key);
    });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double dy) {
      Of(w).camera_.Zoom(static_cast<float>(dy));
    });
    glfwSetCursorPosCallback(window,
                             [](GLFWwindow* w, double x, double y) { Of(w).OnCursor(x, y); });
  }

  void OnKey(int key) {
    switch (key) {
      case GLFW_KEY_1:
        return camera_.SetView(View::kOcclusal);
      case GLFW_KEY_2:
        return camera_.SetView(View::kBuccal);
      case GLFW_KEY_3:
        return camera_.SetView(View::kMesial);
      case GLFW_KEY_4:
        return camera_.SetView(View::kOblique);
      default:
        return;
    }
  }

  void OnCursor(double x, double y) {
    int width = 1, height = 1;
    glfwGetWindowSize(glfw_.get(), &width, &height);
    auto dx = static_cast<float>((x - cursor_x_) / std::max(height, 1));
    auto dy = static_cast<float>((y - cursor_y_) / std::max(height, 1));
    cursor_x_ = x;
    cursor_y_ = y;
    auto held = [&](int button) { return glfwGetMouseButton(glfw_.get(), button) == GLFW_PRESS; };
    if (held(GLFW_MOUSE_BUTTON_LEFT))
      camera_.Orbit(dx, dy);
    else if (held(GLFW_MOUSE_BUTTON_RIGHT) || held(GLFW_MOUSE_BUTTON_MIDDLE))
      camera_.Pan(dx, dy);
  }

  PictureState PictureNow(float aspect) {
    PictureState picture;
    picture.view_from_scene = camera_.ViewFromScene();
    picture.clip_from_view = camera_.ClipFromView(aspect);
    if (!has_state_) return picture;
    picture.scene_from_bur = FromPose(state_.anchor);
    if (glm::length(state_.device.tip_m - state_.anchor.tip_m) > kGhostFrom_m) {
      picture.scene_from_ghost = FromPose(state_.device);
    }
    dvec3 middle = state_.anchor.tip_m +
                   state_.anchor.orientation.Matrix()[2] * (0.5 * options_.bur.height_m());
    picture.arrow_from_mm = glm::vec3(middle * 1000.0);
    picture.arrow_mm =
        glm::vec3(state_.force_sent_n / options_.force_full_scale_n) * kArrowFullScale_mm;
    if (state_.bur_on) spin_ += kSpinPerFrame;
    picture.bur_spin = spin_;
    return picture;
  }

  void DrawFrame(int oversampling) {
    for (const GroupMesh& mesh : mesher_.TakeReady()) picture_.Replace(mesh);
    has_state_ |= latest_.Read(state_);
    int width = 0, height = 0, window_height = 0;
    glfwGetFramebufferSize(glfw_.get(), &width, &height);
    glfwGetWindowSize(glfw_.get(), nullptr, &window_height);
    if (width == 0 || height == 0) return;  // minimised
    picture_.Draw(PictureNow(static_cast<float>(width) / static_cast<float>(height)), width, height,
                  oversampling);
    picture_.result().Bind();
    if (options_.panel) DrawPanel(window_height);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, picture_.result().name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glfwSwapBuffers(glfw_.get());
  }

  void DrawPanel(int window_height) {
    panel_->Draw({options_.heading, state_, options_.force_full_scale_n, options_.time_limit_s,
                  2.0 * camera_.radius_mm() / std::max(window_height, 1), has_state_});
  }

  // Constant after construction.
  const WindowOptions options_;
  GlfwWindow glfw_;
  const bool software_;
  // Main thread's.
  Camera camera_;
  FrameState state_;
  bool has_state_ = false;
  float spin_ = 0;
  double cursor_x_ = 0, cursor_y_ = 0;
  Clock::time_point next_frame_{};
  // Between threads.
  Latest<FrameState> latest_;
  BrickFeed feed_;
  Mesher mesher_;
  // Main thread's; gone before the context.
  Picture picture_;
  std::optional<Panel> panel_;
};

Result<std::unique_ptr<Window>> Window::Create(const WindowOptions& options,
                                               const cutting::Volume& initial) {
  try {
    return std::unique_ptr<Window>(new Window(std::make_unique<Impl>(options, initial)));
  } catch (const std::exception& e) {
    return Status(
        Code::kUnavailable,
        std::string("expected a display with OpenGL 3.3, found: ") + e.what() +
            "; start a desktop session, set DISPLAY, use xvfb-run, or run without --window",
        "window");
  }
}

Window::Window(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Window::~Window() = default;

void Window::Publish(const FrameState& state) noexcept { impl_->Publish(state); }
void Window::PublishBricks(const cutting::Volume& volume,
                           std::span<const int32_t> touched) noexcept {
  impl_->PublishBricks(volume, touched);
}
void Window::FlushBricks(const cutting::Volume& volume) { impl_->FlushBricks(volume); }
bool Window::PumpOnce() { return impl_->PumpOnce(); }
void Window::Run(const std::function<bool()>& done) {
  while (!done() && impl_->PumpOnce()) {
  }
}
Status Window::WriteScreenshot(const std::string& path) { return impl_->WriteScreenshot(path); }
void Window::SetView(View view) { impl_->SetView(view); }

}  // namespace enamel::station::render
