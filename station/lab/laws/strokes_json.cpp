#include <cmath>
#include <cstdio>

#include "common/core/params.h"
#include "station/lab/laws/strokes.h"

// Written by hand, not with a library's numbers: plots need four digits, and a report has to stay
// below the server's 1 MiB.
namespace enamel::station::lab {
namespace {

std::string Digits(double v, const char* format = "%.4g") {
  if (!std::isfinite(v)) return "null";
  char out[40];
  std::snprintf(out, sizeof out, format, v);
  return std::string(out) == "-0" ? "0" : out;
}

// Titles are our own or a profile's: quotes, backslashes and control characters are escaped.
std::string Quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", c);
      out += code;
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string Column(const char* name, const StrokeTrack& track, const std::vector<size_t>& at,
                   double StrokePoint::*member, double factor, const char* format = "%.4g") {
  std::string out = std::string("\"") + name + "\":[";
  for (size_t i = 0; i < at.size(); ++i) {
    if (i > 0) out += ',';
    out += Digits(track.points[at[i]].*member * factor, format);
  }
  return out + "]";
}

std::string TrackJson(const StrokeTrack& track, size_t most_points) {
  const std::vector<size_t> at = PointsToDraw(track.points, most_points);
  std::string out = "{\"law\":" + Quoted(std::string(haptics::FindLaw(track.law)->name)) +
                    ",\"default\":" + (track.law == haptics::kDefaultLaw ? "true" : "false") +
                    ",\"held\":" + (track.held() ? "true" : "false") +
                    ",\"ticks\":" + std::to_string(track.points.size()) +
                    ",\"leaves_s\":" + (track.leaves_s ? Digits(*track.leaves_s, "%.6g") : "null") +
                    ",\"figures\":[";
  for (size_t i = 0; i < track.figures.size(); ++i) {
    const StrokeFigure& f = track.figures[i];
    out += std::string(i > 0 ? "," : "") + "{\"name\":" + Quoted(f.name) +
           ",\"unit\":" + Quoted(f.unit) + ",\"value\":" + Digits(f.value) +
           ",\"bound\":" + (f.bound ? Digits(*f.bound) : "null") +
           ",\"held\":" + (f.held() ? "true" : "false") + "}";
  }
  out += "]," + Column("t_s", track, at, &StrokePoint::t_s, 1, "%.6g");
  out += "," + Column("force_n", track, at, &StrokePoint::force_n, 1);
  out += "," + Column("magnitude_n", track, at, &StrokePoint::magnitude_n, 1);
  out += "," + Column("ideal_n", track, at, &StrokePoint::ideal_n, 1);
  out += "," + Column("oracle_n", track, at, &StrokePoint::oracle_n, 1);
  out += "," + Column("tip_mm", track, at, &StrokePoint::tip_m, 1e3);
  out += "," + Column("bur_mm", track, at, &StrokePoint::bur_m, 1e3);
  return out + "}";
}

}  // namespace

std::string StrokesJson(const std::vector<StrokeDevice>& devices, size_t most_points) {
  std::string out = "{\"format\":1,\"core_version\":" + std::to_string(core::kCoreVersion) +
                    ",\"b_n_s_per_mm\":6.5,\"devices\":[";
  for (size_t i = 0; i < devices.size(); ++i) {
    const DeviceModel& m = devices[i].model;
    out += std::string(i > 0 ? "," : "") + "{\"name\":" + Quoted(m.name) +
           ",\"title\":" + Quoted(m.title) + ",\"rate_hz\":" + Digits(m.rate_hz, "%.6g") +
           ",\"delay_ticks\":" + std::to_string(m.delay_ticks) +
           ",\"kc_n_per_mm\":" + Digits(m.kc_n_per_m * 1e-3) +
           ",\"resolution_um\":" + Digits(m.resolution_m * 1e6) +
           ",\"peak_force_n\":" + Digits(m.peak_force_n) +
           ",\"continuous_force_n\":" + Digits(m.continuous_force_n) + ",\"cases\":[";
    const std::vector<StrokeTrack>& tracks = devices[i].tracks;
    for (size_t k = 0; k < tracks.size(); ++k) {
      const bool begins = k == 0 || tracks[k].which != tracks[k - 1].which;
      if (begins)
        out += std::string(k > 0 ? "]}," : "") +
               "{\"name\":" + Quoted(StrokeName(tracks[k].which)) + ",\"tracks\":[";
      out += std::string(begins ? "" : ",") + TrackJson(tracks[k], most_points);
    }
    out += tracks.empty() ? "]}" : "]}]}";
  }
  return out + "]}";
}

}  // namespace enamel::station::lab
