import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Client } from "../api/client";
import { queryText } from "../api/request_init";
import type { Person, Session } from "../api/types";
import { unreachable } from "../base/assert";
import { draftsOf, eraseDrafts } from "../base/drafts";
import type { Language } from "../base/language";
import { loadWords, say, sayWith } from "../base/words";
import { ConfirmPassword } from "../features/account/confirm_password";
import { ForcedPassword } from "../features/account/forced_password";
import { MyWorkPage } from "../features/assignments/my_work_page";
import { AttemptsPage } from "../features/attempts/attempts_page";
import { ExercisesPage, StaffExercisesPage } from "../features/exercises/exercises_page";
import { FirstAdmin } from "../features/sign_in/first_admin";
import { SignIn } from "../features/sign_in/sign_in";
import { ErrorNotice, Loading, PageTitle } from "../widgets/basics";
import { BrandMark } from "../widgets/brand";
import { drawTeethWith } from "../tooth/link";
import { part } from "../widgets/part";
import { answers, toothWorker } from "./begin";
import { keepLanguage, language, applyLanguage } from "./language";
import { location, navigate } from "./location";
import { homePath, navigation, parseRoute, type Route } from "./routes";
import { useNews } from "./use_news";

// Who is using the page. The address stays while signed out, so that signing in again leads back.
type SessionState =
  | { readonly state: "unknown" }
  | { readonly state: "unreachable"; readonly message: string }
  | { readonly state: "out"; readonly notice?: string }
  | {
      readonly state: "in";
      readonly person: Person;
      readonly language: Session["language"];
      readonly mustChange: boolean;
      readonly mayImport: boolean; // teeth
    };

const session = signal<SessionState>({ state: "unknown" });
drawTeethWith(toothWorker);
const client = new Client(
  () => {
    if (session.value.state !== "in") return;
    session.value = { state: "out", notice: say("session.ended") };
  },
  undefined,
  answers,
);

// The question for the password that is open, if any, and who waits for its answer.
const confirming = signal<((confirmed: boolean) => void) | undefined>(undefined);
client.confirm = () =>
  new Promise((resolve) => {
    confirming.value?.(false);
    confirming.value = (confirmed) => {
      confirming.value = undefined;
      resolve(confirmed);
    };
  });

// Begins what the address shows. Returns the parts whose words it needs.
export function beginParts(): ("attempt_page" | "exercise_page")[] {
  const route = parseRoute(location.value);
  if (route.name !== "attempt" && route.name !== "exercise") return [];
  const { id } = route;
  const begun =
    route.name === "attempt"
      ? OneAttempt.begin().then(({ beginPlayback }) => beginPlayback(client, id))
      : OneExercise.begin();
  begun.catch(() => undefined); // told when it is to be shown
  return [`${route.name}_page`];
}

export async function restoreSession(): Promise<void> {
  const result = await client.currentSession();
  if (result.ok) await signedIn(result.value);
  else if (result.error.code === "unauthenticated") session.value = { state: "out" };
  else session.value = { state: "unreachable", message: result.error.message };
}

// `chosen`: the language that somebody chose before signing in, which is kept with the person then.
async function signedIn(begun: Session, chosen?: Language): Promise<void> {
  const { person, must_change_password: mustChange } = begun;
  const kept =
    chosen === undefined || chosen === begun.language
      ? begun
      : await client
          .put("/session/language", { body: { language: chosen } })
          .then((result) => (result.ok ? result.value : begun));
  // Where its words cannot be loaded, the page keeps its language, and the account page reports
  // that.
  await applyLanguage(kept.language);
  // Without them built-in exercises are as the server has them, in English.
  await loadWords("builtin").catch(() => undefined);
  chosenBefore.value = undefined;
  draftsOf(person.id);
  session.value = {
    state: "in",
    person,
    language: kept.language,
    mustChange,
    mayImport: begun.may_import_teeth,
  };
}

// Before anybody is signed in: for this browser, and for the next person who signs in.
const chosenBefore = signal<Language | undefined>(undefined);
async function chooseBefore(code: Language): Promise<void> {
  keepLanguage(code);
  if (await applyLanguage(code)) chosenBefore.value = code;
}

// Why not, where it could not be kept or its words could not be loaded.
async function choose(language: Session["language"]): Promise<string | undefined> {
  const kept = await client.put("/session/language", { body: { language } });
  if (!kept.ok) return kept.error.message;
  if (!(await applyLanguage(language))) return say("account.language_words_failed");
  if (session.value.state === "in") session.value = { ...session.value, language };
  return undefined;
}

// The first admin continues with the first steps; the link is used up.
function begun(begin: Session): void {
  navigate("/health", "replace");
  void signedIn(begin);
}

async function signOut(): Promise<void> {
  const result = await client.signOut();
  if (!result.ok && result.error.code !== "unauthenticated") {
    session.value = { state: "unreachable", message: say("session.maybe_signed_in", { reason: result.error.message }) };
    return;
  }
  eraseDrafts();
  navigate("/");
  session.value = { state: "out" };
}

// Another language draws the whole page again.
export function App() {
  return <Screen key={language.value} />;
}

function Screen() {
  const now = session.value;
  switch (now.state) {
    case "unknown":
      return <Loading what={say("loading.page")} />;
    case "unreachable":
      return (
        <main id="content" class="sign-in">
          <h1>Enamel</h1>
          <ErrorNotice
            title={say("app.server_unexpected")}
            message={now.message}
            onRetry={() => void restoreSession()}
          />
        </main>
      );
    case "out":
      if (location.value.pathname === "/first")
        return <FirstAdmin client={client} token={window.location.hash.slice(1)} onSignedIn={begun} />;
      return (
        <SignIn
          client={client}
          notice={now.notice}
          chosen={chosenBefore.value}
          onLanguage={(code) => void chooseBefore(code)}
          onSignedIn={(begin, chosen) => void signedIn(begin, chosen)}
        />
      );
    case "in":
      if (now.mustChange)
        return (
          <ForcedPassword
            client={client}
            person={now.person}
            onChanged={(begin) => void signedIn(begin)}
            onSignOut={() => void signOut()}
          />
        );
      return <SignedIn person={now.person} />;
    default:
      return unreachable(now);
  }
}

function SignedIn({ person }: { readonly person: Person }) {
  const url = location.value;
  const route = parseRoute(url);
  useEffect(() => {
    if (route.name === "home") navigate(homePath(person.role), "replace");
  }, [route.name, person.role]);
  return (
    <>
      <a class="skip" href="#content">
        {say("app.skip")}
      </a>
      <Header person={person} path={url.pathname} />
      <main id="content" key={url.pathname} data-route={route.name}>
        {screen(route, person)}
      </main>
      {confirming.value !== undefined && <ConfirmPassword client={client} onAnswer={confirming.value} />}
    </>
  );
}

function Header({ person, path }: { readonly person: Person; readonly path: string }) {
  const list = useRef<HTMLElement>(null);
  const news = useNews(client, person.role);
  // On a narrow screen the row of pages scrolls sideways: the one that is open is brought into it.
  useEffect(() => {
    const open = list.current?.querySelector<HTMLElement>("[aria-current]");
    if (list.current !== null && open != null)
      list.current.scrollLeft = open.offsetLeft - (list.current.clientWidth - open.offsetWidth) / 2;
  }, [path, news]);
  return (
    <header class="header">
      <a class="brand" href={homePath(person.role)}>
        <BrandMark />
        <span>Enamel</span>
      </a>
      <nav aria-label={say("app.main")} ref={list}>
        <ul>
          {navigation(person.role).map((item) => (
            <li key={item.path}>
              <a
                href={item.path}
                title={news[item.path]?.what}
                {...(path === item.path || path.startsWith(`${item.path}/`) ? { "aria-current": "page" as const } : {})}
              >
                {item.title}
                {news[item.path] !== undefined && (
                  <span class="nav-news" aria-hidden="true">
                    {news[item.path]?.count}
                  </span>
                )}
              </a>
            </li>
          ))}
        </ul>
      </nav>
      <div class="account">
        {person.role === "admin" && (
          <a class="button small" href="/search" {...(path === "/search" ? { "aria-current": "page" as const } : {})}>
            {say("search.title")}
          </a>
        )}
        <a class="account-name" href="/account" {...(path === "/account" ? { "aria-current": "page" as const } : {})}>
          {person.display_name}
          <span class="account-role">{say(`role.${person.role}`)}</span>
        </a>
        <button type="button" class="button small" onClick={() => void signOut()}>
          {say("session.sign_out")}
        </button>
      </div>
    </header>
  );
}

const Account = part("account_page", () => import("../features/account/account_page"));
const OneAttempt = part("attempt_page", () => import("../features/attempt/attempt_page"));
const OneExercise = part("exercise_page", () => import("../features/exercises/exercise_page"));
const Staff = part("staff", () => import("./staff"));

function screen(route: Route, person: Person): ComponentChildren {
  const teacher = person.role !== "student";
  const narrow = (query: Readonly<Record<string, string>>) =>
    navigate(location.value.pathname + queryText(query), "replace");
  switch (route.name) {
    case "home":
      return null;
    case "exercises":
      return teacher ? (
        <StaffExercisesPage
          client={client}
          admin={person.role === "admin"}
          mayImport={session.value.state === "in" && session.value.mayImport}
          query={route.query}
          onQuery={narrow}
          onOpen={navigate}
        />
      ) : (
        <ExercisesPage client={client} />
      );
    case "exercise":
      return (
        <OneExercise
          show={({ ExercisePage }) => (
            <ExercisePage client={client} id={route.id} personId={person.id} teacher={teacher} onOpen={navigate} />
          )}
        />
      );
    case "attempts":
      return <AttemptsPage client={client} mine={!teacher} query={route.query} onQuery={narrow} />;
    case "attempt":
      return (
        <OneAttempt
          show={({ AttemptPage }) => <AttemptPage client={client} person={person} id={route.id} onOpen={navigate} />}
        />
      );
    case "account":
      return (
        <Account
          show={({ AccountPage }) => (
            <AccountPage
              client={client}
              person={person}
              language={session.value.state === "in" ? session.value.language : ""}
              onLanguage={choose}
            />
          )}
        />
      );
    case "assignments":
      if (!teacher) return <MyWorkPage client={client} />;
      break;
    default:
      break;
  }
  const notFound = <NotFound home={homePath(person.role)} />;
  return teacher ? (
    <Staff
      show={({ staffScreen }) => staffScreen({ client, route, person, onQuery: narrow, onOpen: navigate }) ?? notFound}
    />
  ) : (
    notFound
  );
}

function NotFound({ home }: { readonly home: string }) {
  return (
    <>
      <PageTitle document={say("app.not_found")}>{say("app.no_such_page")}</PageTitle>
      <p>{sayWith("app.check_address", { start: <a href={home}>{say("app.the_start")}</a> })}</p>
    </>
  );
}
