#include "server/postgres/pg_statement.h"

#include <bit>
#include <cmath>
#include <utility>

namespace enamel::sql {
namespace {

// Object identifiers of the built-in types: fixed, in PostgreSQL's pg_type.dat.
enum : Oid {
  kBool = 16,
  kBytea = 17,
  kName = 19,
  kInt8 = 20,
  kInt2 = 21,
  kInt4 = 23,
  kText = 25,
  kFloat4 = 700,
  kFloat8 = 701,
  kUnknown = 705,
  kVarchar = 1043,
  kNumeric = 1700,
};

Oid OidOf(Type type) {
  switch (type) {
    case Type::kInt:
      return kInt8;
    case Type::kReal:
      return kFloat8;
    case Type::kText:
      return kText;
    case Type::kBlob:
      return kBytea;
    case Type::kNull:
      break;
  }
  return 0;  // PostgreSQL takes it from where the parameter stands
}

std::string BigEndian(uint64_t value) {
  std::string out(8, '\0');
  for (size_t i = 0; i < 8; ++i) out[i] = static_cast<char>(value >> (56 - 8 * i));
  return out;
}

uint64_t Unsigned(ByteView bytes) {
  uint64_t out = 0;
  for (const uint8_t byte : bytes) out = out << 8 | byte;
  return out;
}

// The result of sum and avg over integers: digits to the base of 10 000 (numeric_send in
// PostgreSQL's numeric.c): their number, weight of the first, sign, decimal places, digits.
double NumericValue(ByteView bytes) {
  auto word = [&](size_t i) { return static_cast<int16_t>(Unsigned(bytes.subspan(2 * i, 2))); };
  if (bytes.size() < 8) return 0;
  const auto digits = static_cast<size_t>(word(0));
  if (bytes.size() < 8 + 2 * digits) return 0;
  constexpr int16_t kNegative = 0x4000;
  double out = 0;
  for (size_t i = 0; i < digits; ++i) {
    out += word(4 + i) * std::pow(10'000.0, word(1) - static_cast<int>(i));
  }
  return word(2) == kNegative ? -out : out;
}

bool NumericIsWhole(ByteView bytes) {
  return bytes.size() >= 8 && Unsigned(bytes.subspan(6, 2)) == 0;
}

int64_t NumericWhole(ByteView bytes) {
  auto word = [&](size_t i) { return static_cast<int16_t>(Unsigned(bytes.subspan(2 * i, 2))); };
  if (bytes.size() < 8) return 0;
  const int digits = word(0), weight = word(1);
  // Beyond what 64 bits hold there is no whole to give.
  if (weight > 4 || bytes.size() < 8 + 2 * static_cast<size_t>(digits)) return 0;
  uint64_t out = 0;
  for (int i = 0; i <= weight; ++i) {
    out = out * 10'000 + (i < digits ? static_cast<uint64_t>(word(4 + static_cast<size_t>(i))) : 0);
  }
  return word(2) == 0x4000 ? -static_cast<int64_t>(out) : static_cast<int64_t>(out);
}

}  // namespace

PgStatement::~PgStatement() { Forget(); }

void PgStatement::Forget() {
  if (result_ != nullptr) db_.pq_.clear(result_);
  result_ = nullptr;
  row_ = -1;
}

bool PgStatement::busy() const {
  return result_ != nullptr && row_ >= 0 && row_ < db_.pq_.ntuples(result_);
}

std::string PgStatement::name() const {
  return prepared_in_ == db_.connection_ ? name_ : std::string();
}

bool PgStatement::Bind(int place, Oid type, std::string bytes) {
  if (static_cast<size_t>(place) > parameters_.size())
    parameters_.resize(static_cast<size_t>(place));
  parameters_[static_cast<size_t>(place) - 1] = {type, false, std::move(bytes)};
  return true;
}

bool PgStatement::BindInt(int place, int64_t value) {
  return Bind(place, kInt8, BigEndian(static_cast<uint64_t>(value)));
}

bool PgStatement::BindReal(int place, double value) {
  return Bind(place, kFloat8, BigEndian(std::bit_cast<uint64_t>(value)));
}

bool PgStatement::BindText(int place, std::string_view value) {
  return Bind(place, kText, std::string(value));
}

bool PgStatement::BindBlob(int place, ByteView value) {
  return Bind(place, kBytea, std::string(AsText(value)));
}

bool PgStatement::BindNull(int place, Type type) {
  Bind(place, OidOf(type), {});
  parameters_[static_cast<size_t>(place) - 1].null = true;
  return true;
}

Status PgStatement::Prepare() {
  std::vector<Oid> types;
  for (const Parameter& parameter : parameters_) types.push_back(parameter.type);
  if (prepared_in_ == db_.connection_ && types == prepared_types_) return Status::Ok();
  name_ = "s" + std::to_string(++db_.names_);
  PGresult* const result =
      db_.LastAnswer(db_.pq_.send_prepare(db_.handle_, name_.c_str(), sql_.c_str(),
                                          static_cast<int>(types.size()), types.data()) == 1);
  Status done = db_.pq_.result_status(result) == PGRES_COMMAND_OK ? Status::Ok() : db_.Fail(result);
  db_.pq_.clear(result);
  ENAMEL_RETURN_IF_ERROR(done);
  prepared_in_ = db_.connection_;
  prepared_types_ = std::move(types);
  return done;
}

PgArguments::PgArguments(const std::vector<PgStatement::Parameter>& parameters) {
  for (const PgStatement::Parameter& parameter : parameters) {
    values.push_back(parameter.null ? nullptr : parameter.bytes.data());
    lengths.push_back(static_cast<int>(parameter.bytes.size()));
    formats.push_back(1);
  }
}

Result<PgStatement::Call> PgStatement::ToSendLater() {
  if (db_.InjectedFailure()) return Status(Code::kStorage, "injected failure");
  ENAMEL_RETURN_IF_ERROR(Prepare());
  return Call{name_, std::move(parameters_)};
}

Status PgStatement::Execute() {
  if (db_.InjectedFailure()) return Status(Code::kStorage, "injected failure");
  ENAMEL_RETURN_IF_ERROR(Prepare());
  const PgArguments with(parameters_);
  result_ = db_.LastAnswer(db_.pq_.send_query_prepared(db_.handle_, name_.c_str(), with.count(),
                                                       with.values.data(), with.lengths.data(),
                                                       with.formats.data(), /*binary*/ 1) == 1);
  const ExecStatusType status = db_.pq_.result_status(result_);
  if (status != PGRES_TUPLES_OK && status != PGRES_COMMAND_OK) {
    Status failed = db_.Fail(result_);
    Forget();
    return failed;
  }
  // For a SELECT this is the number of its rows, which are no changes.
  if (status == PGRES_COMMAND_OK) db_.changes_ = db_.RowsOf(result_);
  return Status::Ok();
}

Statement::Step PgStatement::Next() {
  if (result_ == nullptr) {
    failure_ = Execute();
    if (!failure_.ok() && db_.IsThereAgain()) failure_ = Execute();
    if (!failure_.ok()) return Step::kFailed;
  }
  return ++row_ < db_.pq_.ntuples(result_) ? Step::kRow : Step::kEnd;
}

int PgStatement::columns() const { return result_ == nullptr ? 0 : db_.pq_.nfields(result_); }

std::string PgStatement::NameOf(int column) const {
  const char* name = result_ == nullptr ? nullptr : db_.pq_.fname(result_, column);
  return name == nullptr ? "" : name;
}

ByteView PgStatement::Raw(int column) const {
  return {reinterpret_cast<const uint8_t*>(db_.pq_.getvalue(result_, row_, column)),
          static_cast<size_t>(db_.pq_.getlength(result_, row_, column))};
}

Type PgStatement::TypeOf(int column) const {
  if (result_ == nullptr || column >= columns() || row_ < 0 || row_ >= db_.pq_.ntuples(result_) ||
      db_.pq_.getisnull(result_, row_, column) != 0) {
    return Type::kNull;
  }
  switch (db_.pq_.ftype(result_, column)) {
    case kBool:
    case kInt2:
    case kInt4:
    case kInt8:
      return Type::kInt;
    case kFloat4:
    case kFloat8:
      return Type::kReal;
    case kNumeric:
      return NumericIsWhole(Raw(column)) ? Type::kInt : Type::kReal;
    case kBytea:
      return Type::kBlob;
    default:
      return Type::kText;
  }
}

int64_t PgStatement::Int(int column) const {
  if (TypeOf(column) == Type::kNull) return 0;
  const ByteView raw = Raw(column);
  switch (db_.pq_.ftype(result_, column)) {
    case kBool:
    case kInt8:
      return static_cast<int64_t>(Unsigned(raw));
    case kInt2:
      return static_cast<int16_t>(Unsigned(raw));
    case kInt4:
      return static_cast<int32_t>(Unsigned(raw));
    case kNumeric:
      return NumericWhole(raw);
    case kFloat4:
    case kFloat8:
      return static_cast<int64_t>(Real(column));
    default:
      return 0;
  }
}

double PgStatement::Real(int column) const {
  if (TypeOf(column) == Type::kNull) return 0;
  const ByteView raw = Raw(column);
  switch (db_.pq_.ftype(result_, column)) {
    case kFloat8:
      return std::bit_cast<double>(Unsigned(raw));
    case kFloat4:
      return std::bit_cast<float>(static_cast<uint32_t>(Unsigned(raw)));
    case kNumeric:
      return NumericValue(raw);
    default:
      return static_cast<double>(Int(column));
  }
}

ByteView PgStatement::View(int column) const {
  const Type type = TypeOf(column);
  return type == Type::kText || type == Type::kBlob ? Raw(column) : ByteView();
}

void PgStatement::GiveBack() {
  Forget();
  parameters_.clear();
  failure_ = Status::Ok();
  --users_;
}

}  // namespace enamel::sql
