#include "station/lab/sheet/fault_sheet.h"

#include <map>
#include <utility>

#include "common/language/score_text.h"
#include "common/scoring/reasons.h"
#include "station/lab/sheet/examples.h"
#include "station/words/score_words.h"

namespace enamel::station::lab {
namespace {

using language::Language;
using language::Words;

constexpr std::string_view kHeavyHand = "heavy_hand", kForce = "force_sent_p95_n";

constexpr char kStyle[] = R"(
@page{size:A4;margin:12mm}
*{box-sizing:border-box}
body{font:10.5pt/1.35 "Noto Sans","DejaVu Sans","Noto Sans CJK SC","PingFang SC","Microsoft YaHei",sans-serif;
 color:#1a1a1a;background:#fff;max-width:190mm;margin:0 auto;padding:4mm}
h1{font-size:17pt;margin:0 0 2mm}h2{font-size:12pt;margin:0 0 1mm}p{margin:0 0 1.5mm}
article{display:grid;grid-template-columns:86mm 1fr;gap:0 5mm;border-top:.3mm solid #999;padding:2.5mm 0;
 break-inside:avoid}
.pictures{display:grid;grid-template-columns:1fr 1fr;gap:1mm 2mm;align-items:end;font-size:8pt;text-align:center}
.pictures svg{width:42mm;max-height:38mm;background:#fff}
.plane{grid-column:1/3;color:#555}
dl{margin:0;display:grid;grid-template-columns:24mm 1fr;gap:.8mm 2mm}dt{color:#555;font-size:9pt}dd{margin:0}
.legend{display:flex;flex-wrap:wrap;gap:1mm 5mm;font-size:9pt;align-items:center;margin-bottom:3mm}
.legend svg{width:7mm;height:4mm;vertical-align:middle;margin-right:1mm}
path{stroke:none;fill-rule:evenodd}
.enamel{fill:#f4eddc;stroke:#6b6252;stroke-width:4}.dentin{fill:#e6c98f}.pulp{fill:#d98a8a}.caries{fill:#6d4c33}
.gypsum{fill:#dedede}.neighbour{fill:#c9d3da}
.over{fill:url(#over);stroke:#a80f1f;stroke-width:5}.left{fill:url(#left);stroke:#0b4f9c;stroke-width:5}
.should{fill:none;stroke:#111;stroke-width:5;stroke-dasharray:16 12}
.scale{fill:none;stroke:#111;stroke-width:8}.force{fill:none;stroke:#111;stroke-width:6}
.limit{fill:none;stroke:#a80f1f;stroke-width:4;stroke-dasharray:16 12}
)";
constexpr char kPatterns[] =
    R"svg(<svg width="0" height="0" style="position:absolute" aria-hidden="true"><defs>
<pattern id="over" width="22" height="22" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path style="fill:#f7b5bb" d="M0 0h22v22h-22z"/><path style="fill:#a80f1f" d="M0 0h8v22h-8z"/></pattern>
<pattern id="left" width="22" height="22" patternUnits="userSpaceOnUse"><path style="fill:#bcd8f5;fill-opacity:.45" d="M0 0h22v22h-22z"/><path style="fill:#0b4f9c" d="M6 6h9v9h-9z"/></pattern>
</defs></svg>
)svg";

std::string Escaped(std::string_view text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}
std::string In(const char* tag, std::string_view text) {
  return std::string("<") + tag + ">" + Escaped(text) + "</" + tag + ">";
}

// Newtons over time against a limit of 4 N, once below it and once above.
std::string ForcePictures() {
  constexpr char kPicture[] =
      R"(<svg viewBox="0 0 420 300" aria-hidden="true"><path class="scale" d="M30 20v250h370"/>)"
      R"(<path class="limit" d="M30 150h370"/><path class="force" d=")";
  return std::string(kPicture) +
         R"(M30 270l30-90 40 12 40-18 50 14 60-20 50 16 60-10 20 96"/></svg>)" + kPicture +
         R"(M30 270l30-170 40 18 40-48 50 30 60-52 50 40 60-22 20 204"/></svg>)";
}

struct Shown {
  std::string said, why, advice, pictures, plane;
};

std::string PlaneKey(Plane plane, bool tooth) {
  if (!tooth) return "fault_sheet.plane_block";
  switch (plane) {
    case Plane::kMesiodistal:
      return "fault_sheet.plane_mesiodistal";
    case Plane::kBuccolingual:
      return "fault_sheet.plane_buccolingual";
    case Plane::kLevel:
      return "fault_sheet.plane_level";
  }
  return "";
}

Result<Shown> Show(const Words& words, const Example& example, const GradedExercise& graded,
                   const std::vector<Fault>& made) {
  ENAMEL_ASSIGN_OR_RETURN(const MadeExample is, Make(example, graded, made));
  Shown out;
  out.said = MistakeText(words, is.mistake);
  out.why = words.Say("fault_why." + std::string(NameOf(example.kind)));
  out.advice = RemedyText(words, is.mistake);
  out.pictures = DrawSections(is.cut, example.plane);
  if (out.pictures.empty()) {
    return Status(Code::kInternal,
                  "the example of " + std::string(NameOf(example.kind)) + ": nothing differs");
  }
  out.plane = words.Say(PlaneKey(example.plane, graded.built().scene.tooth != 0));
  return out;
}

// No tooth shows it.
Shown HeavyHand(const Words& words) {
  constexpr double kHeavy_n = 6.2;
  const scoring::MetricInfo& info = *scoring::FindMetric(kForce);
  const scoring::Remedy* remedy = scoring::FindRemedy(kForce, true);
  scoring::CriterionResult said;
  said.name = info.name;
  said.title = "Light hand";
  said.unit = info.unit;
  said.value = kHeavy_n;
  said.reasons = {scoring::FoundReason(info, kHeavy_n, {{4, 1}, {8, 0}})};
  return {ReasonText(words, said), words.Say("fault_why.heavy_hand"),
          words.Say("reason." + std::string(remedy->code)), ForcePictures(),
          words.Say("fault_sheet.plane_force")};
}

// By scene and exercise, so that each is built once.
class Shower {
 public:
  Shower(const FaultSheetOptions& options, const Words& words)
      : voxel_nm_(options.voxel_nm), words_(words) {}

  // All examples. `step` is called before each.
  Result<std::map<scoring::MistakeKind, Shown>> ShowAll(const std::function<void(double)>& step) {
    std::map<scoring::MistakeKind, Shown> out;
    std::map<std::pair<std::string_view, std::string_view>, std::vector<const Example*>> places;
    for (const Example& e : Examples()) places[{e.scene, e.exercise}].push_back(&e);
    for (const auto& [place, examples] : places) {
      ENAMEL_ASSIGN_OR_RETURN(const auto built,
                              scene::BuildBuiltinScene(std::string(place.first), voxel_nm_));
      ENAMEL_ASSIGN_OR_RETURN(const GradedExercise graded, GradedOf(built, place.second));
      const auto made = FaultsOf(built, graded.exercise(), graded.task(), true);
      for (const Example* example : examples) {
        if (step) step(static_cast<double>(out.size()) / static_cast<double>(Examples().size()));
        ENAMEL_ASSIGN_OR_RETURN(out[example->kind], Show(words_, *example, graded, made));
      }
    }
    return out;
  }

 private:
  static Result<GradedExercise> GradedOf(const scene::BuiltScene& built, std::string_view begins) {
    for (scene::Exercise& e : scene::BuiltinExercises(built.scene, {})) {
      if (e.name.starts_with(begins)) return GradedExercise::Make(built, std::move(e));
    }
    return Status(Code::kInternal, "no exercise '" + std::string(begins) + "' in " +
                                       built.scene.name + ", for an example of the sheet");
  }

  const int32_t voxel_nm_;
  const Words& words_;
};

std::string LegendItem(const std::string& name, const std::string& text) {
  return "<span><svg viewBox=\"0 0 70 40\" aria-hidden=\"true\"><path class=\"" + name +
         "\" d=\"M3 3h64v34h-64z\"/></svg>" + Escaped(text) + "</span>";
}

std::string Head(const Words& words, size_t mistakes) {
  const std::string title = words.Say("fault_sheet.title");
  std::string out =
      "<!doctype html>\n<html lang=\"" + std::string(CodeOf(words.language())) +
      "\"><head><meta charset=\"utf-8\">" + In("title", title) + "<style>" + kStyle +
      "</style></head><body>\n" + kPatterns + In("h1", title) +
      In("p", words.Say("fault_sheet.intro", {{"count", static_cast<int64_t>(mistakes)}})) +
      "<div class=\"legend\">";
  out += LegendItem("over", words.Say("fault_sheet.over"));
  out += LegendItem("left", words.Say("fault_sheet.left"));
  out += LegendItem("should", words.Say("fault_sheet.should"));
  for (const char* tissue : {"enamel", "dentin", "pulp", "caries", "neighbour", "gypsum"}) {
    out += LegendItem(tissue, words.Say(std::string("tissue.") + tissue));
  }
  return out + In("span", words.Say("fault_sheet.scale")) + "</div>\n";
}

std::string Card(const Words& words, std::string_view id, const Shown& shown) {
  return "<article id=\"" + std::string(id) + "\"><div class=\"pictures\">" + shown.pictures +
         In("span", words.Say("fault_sheet.should_be")) +
         In("span", words.Say("fault_sheet.was_cut")) + "<span class=\"plane\">" +
         Escaped(shown.plane) + "</span></div><div>" + In("h2", shown.said) + "<dl>" +
         In("dt", words.Say("fault_sheet.why")) + In("dd", shown.why) +
         In("dt", words.Say("fault_sheet.next_time")) + In("dd", shown.advice) +
         "</dl></div></article>\n";
}

}  // namespace

Result<std::string> FaultSheet(const FaultSheetOptions& options,
                               const std::function<void(double)>& progress) {
  const Words words(options.language);
  ENAMEL_ASSIGN_OR_RETURN(const auto shown, Shower(options, words).ShowAll(progress));
  std::string out = Head(words, shown.size() + 1);
  for (const auto& [kind, card] : shown) out += Card(words, NameOf(kind), card);
  return out + Card(words, kHeavyHand, HeavyHand(words)) + "</body></html>\n";
}

}  // namespace enamel::station::lab
