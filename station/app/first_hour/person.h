#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

// Whoever goes through the first hour with a unit: told what to do, asked, and listened to while the
// loop ticks. Thread safety: none, the loop's thread. Real-time: not safe; Listen does not wait.
namespace enamel::station::first_hour {

struct Heard {
  enum class Kind : uint8_t {
    kNothing,  // not yet
    kAnswer,
    kClosed,  // there will be no answer: the input has ended
  };
  Kind kind = Kind::kNothing;
  std::string text = {};  // one line, without blanks around it
};

class Person {
 public:
  virtual ~Person() = default;
  virtual void Tell(const std::string& text) = 0;
  // `id` names the question: "directions.right.to". One that ends with ".yes" asks whether the motors may
  // push.
  virtual void Ask(const std::string& id, const std::string& text) = 0;
  // The answer to the last question, if it has come. `now_s` is the run's time.
  virtual Heard Listen(double now_s) = 0;
};

// Standard output and input. A line longer than 1000 bytes is cut.
class Terminal final : public Person {
 public:
  void Tell(const std::string& text) override;
  void Ask(const std::string& id, const std::string& text) override;
  Heard Listen(double now_s) override;

 private:
  std::string read_;
  bool closed_ = false;
};

// A line of a file of answers: "ID: ANSWER", or "ID @SECONDS: ANSWER" for one that comes so long after the
// question. '#' begins a comment.
struct ScriptLine {
  std::string id;
  double after_s = 0;
  std::string answer;
};
// At most 64 KiB. Errors: kInvalidInput with the line.
Result<std::vector<ScriptLine>> ParseScript(std::string_view text);

// Gives the answers of a script, each once and in its order; then the input has ended. What is told and
// asked goes to `shown`, which answers what a script may not where `consents` is false: whether the motors
// may push.
class Script final : public Person {
 public:
  Script(std::vector<ScriptLine> lines, Person& shown, bool consents)
      : lines_(std::move(lines)), shown_(shown), consents_(consents) {}
  void Tell(const std::string& text) override { shown_.Tell(text); }
  void Ask(const std::string& id, const std::string& text) override;
  Heard Listen(double now_s) override;

 private:
  std::vector<ScriptLine> lines_;
  Person& shown_;
  const bool consents_;
  std::string asked_;
  double since_s_ = -1;  // first Listen after the question
};

}  // namespace enamel::station::first_hour
