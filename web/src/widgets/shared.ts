// What every part of the page uses. Each part names it, so that the build keeps it together in one
// file: a file more costs a request and its head, which for a small one is more than its content.
import "../base/assert";
import "../base/disposables";
import "../base/format";
import "../base/frame";
import "../base/language";
import "../base/result";
import "../base/words";
import "./attempt_state";
import "./basics";
import "./copy";
import "./dialog";
import "./form";
import "./pages";
import "./part";
import "./sessions_table";
import "./table";
