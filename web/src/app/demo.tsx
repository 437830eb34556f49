import { render } from "preact";
import { Client } from "../api/client";
import { type Answers, fromAnswers } from "../api/recorded";
import { check } from "../base/assert";
import type { Language } from "../base/language";
import { say, sayWith } from "../base/words";
import { AttemptPage } from "../features/attempt/attempt_page";
import { canvasAhead } from "../tooth/canvas_ahead";
import { drawTeethWith } from "../tooth/link";
import { BrandMark } from "../widgets/brand";
import { Languages } from "../widgets/languages";
import { applyLanguage, keepLanguage, language } from "./language";

// The page of scripts/demo.mjs: one file that holds an attempt and all that shows it, opened without a server.

interface Demo {
  readonly attempt: string;
  readonly person: string; // whose it is
  readonly repository: string; // its address; empty: not known
  readonly answers: Answers;
}

function held(id: string): string {
  const text = document.getElementById(id)?.textContent;
  check(text != null, `the file has an element with id ${id}`);
  return text;
}

const demo = JSON.parse(held("demo")) as Demo;
const worker = URL.createObjectURL(new Blob([held("worker")], { type: "text/javascript" }));
drawTeethWith(() => {
  const started = new Worker(worker);
  return { worker: started, canvas: canvasAhead(started) };
});
const client = new Client(() => undefined, fromAnswers(demo.answers));

async function choose(code: Language): Promise<void> {
  keepLanguage(code);
  await applyLanguage(code);
}

// Another language draws the whole page again.
function App() {
  return <Screen key={language.value} />;
}

function Screen() {
  const { repository } = demo;
  return (
    <>
      <header class="header of-demo">
        <span class="brand">
          <BrandMark />
          <span>Enamel</span>
        </span>
        <Languages onLanguage={(code) => void choose(code)} />
        <p>{say("demo.what")}</p>
        <p>
          {repository === ""
            ? say("demo.get")
            : sayWith("demo.get_at", { address: <a href={repository}>{repository}</a> })}
        </p>
      </header>
      <main id="content" data-route="attempt">
        <AttemptPage
          client={client}
          person={{ id: demo.person, role: "student" }}
          id={demo.attempt}
          onOpen={() => undefined}
          alone
        />
      </main>
    </>
  );
}

const root = document.getElementById("app");
check(root !== null, "the file has an element with id app");
void applyLanguage("", ["builtin"]).then(() => render(<App />, root));
