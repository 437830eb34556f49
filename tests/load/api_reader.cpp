#include "tests/load/api_reader.h"

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>

#include "tests/load/engine.h"

namespace enamel::load {

ApiReader::ApiReader(net::Endpoint page, const School& school, double reads_per_s)
    : page_(std::move(page)),
      school_(school),
      period_s_(1 / reads_per_s),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void ApiReader::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void ApiReader::Run(const std::stop_token& stop) {
  HttpClient client(page_);
  if (Status status = client.SignIn(school_.instructor_login, school_.password); !status.ok()) {
    problem_ = status.message();
    return;
  }
  double next_s = NowS();
  for (uint64_t turn = 0; !stop.stop_requested(); ++turn, next_s += period_s_) {
    double wait_s = next_s - NowS();
    if (wait_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(wait_s));
    ReadOne(client, turn);
  }
}

void ApiReader::ReadOne(HttpClient& client, uint64_t turn) {
  const std::string paths[] = {"/api/v1/attempts?limit=50", "/api/v1/attempts/" + attempt_,
                               "/api/v1/exercises", "/api/v1/session", "/api/v1/stations"};
  size_t which = turn % 5;
  if (which == 1 && attempt_.empty()) which = 2;
  double from = NowS();
  auto body = client.Get(paths[which]);
  latencies_ms_.push_back(static_cast<float>((NowS() - from) * 1e3));
  if (!body.ok()) {
    ++failures_;
    problem_ = body.status().message();
    return;
  }
  if (which != 0 || !attempt_.empty()) return;
  boost::system::error_code error;
  boost::json::value list = boost::json::parse(*body, error);
  const boost::json::value* first = error ? nullptr : list.find_pointer("/attempts/0/id", error);
  if (first && first->is_string()) attempt_ = std::string(first->as_string());
}

}  // namespace enamel::load
