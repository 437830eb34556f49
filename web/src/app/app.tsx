import { signal } from "@preact/signals";
import type { ComponentChildren, ComponentProps } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Client } from "../api/client";
import { queryText } from "../api/http";
import type { Person, Session } from "../api/types";
import { unreachable } from "../base/assert";
import { AccountPage, ForcedPassword } from "../features/account/account_page";
import { ConfirmPassword } from "../features/account/confirm_password";
import { MyWorkPage } from "../features/assignments/my_work_page";
import type { AttemptPage } from "../features/attempt/attempt_page";
import { AttemptsPage } from "../features/attempts/attempts_page";
import type { ExercisePage } from "../features/exercises/exercise_page";
import { ExercisesPage, StaffExercisesPage } from "../features/exercises/exercises_page";
import { FirstAdmin } from "../features/sign_in/first_admin";
import { SignIn } from "../features/sign_in/sign_in";
import { ErrorNotice, Loading, PageTitle } from "../widgets/basics";
import { BrandMark } from "../widgets/brand";
import "../api/shared";
import "../widgets/shared";
import { PartState, usePart } from "../widgets/part";
import { location, navigate } from "./location";
import { homePath, navigation, parseRoute, type Route } from "./routes";

// Who is using the page. The address stays while signed out, so that signing in again leads back.
type SessionState =
  | { readonly state: "unknown" }
  | { readonly state: "unreachable"; readonly message: string }
  | { readonly state: "out"; readonly notice?: string }
  | { readonly state: "in"; readonly person: Person; readonly mustChange: boolean };

const session = signal<SessionState>({ state: "unknown" });
const client = new Client(() => {
  if (session.value.state !== "in") return;
  session.value = { state: "out", notice: "Your session has ended. Sign in again to continue where you were." };
});

// The question for the password that is open, if any, and who waits for its answer.
const confirming = signal<((confirmed: boolean) => void) | undefined>(undefined);
client.onConfirmPassword(() => new Promise((resolve) => {
  confirming.value?.(false);
  confirming.value = (confirmed) => {
    confirming.value = undefined;
    resolve(confirmed);
  };
}));

export async function restoreSession(): Promise<void> {
  const result = await client.currentSession();
  if (result.ok) signedIn(result.value);
  else if (result.error.code === "unauthenticated") session.value = { state: "out" };
  else session.value = { state: "unreachable", message: result.error.message };
}

function signedIn({ person, must_change_password: mustChange }: Session): void {
  session.value = { state: "in", person, mustChange };
}

// The first admin goes on where the first steps are; the link is used up.
function begun(begin: Session): void {
  navigate("/health", "replace");
  signedIn(begin);
}

async function signOut(): Promise<void> {
  const result = await client.signOut();
  if (!result.ok && result.error.code !== "unauthenticated") {
    session.value = { state: "unreachable", message: `You may still be signed in. ${result.error.message}` };
    return;
  }
  navigate("/");
  session.value = { state: "out" };
}

export function App() {
  const now = session.value;
  switch (now.state) {
    case "unknown": return <Loading what="the page" />;
    case "unreachable":
      return (
        <main id="content" class="sign-in">
          <h1>Enamel</h1>
          <ErrorNotice title="The server does not answer as expected" message={now.message} onRetry={() => void restoreSession()} />
        </main>
      );
    case "out": if (location.value.pathname === "/first") return <FirstAdmin client={client} token={window.location.hash.slice(1)} onSignedIn={begun} />; return <SignIn client={client} notice={now.notice} onSignedIn={signedIn} />;
    case "in":
      if (now.mustChange) return <ForcedPassword client={client} person={now.person} onChanged={signedIn} onSignOut={() => void signOut()} />;
      return <SignedIn person={now.person} />;
    default: return unreachable(now);
  }
}

function SignedIn({ person }: { readonly person: Person }) {
  const url = location.value;
  const route = parseRoute(url);
  useEffect(() => { if (route.name === "home") navigate(homePath(person.role), "replace"); }, [route.name, person.role]);
  return (
    <>
      <a class="skip" href="#content">Skip to content</a>
      <Header person={person} path={url.pathname} />
      <main id="content" key={url.pathname}>{screen(route, person)}</main>
      {confirming.value !== undefined && <ConfirmPassword client={client} onAnswer={confirming.value} />}
    </>
  );
}

function Header({ person, path }: { readonly person: Person; readonly path: string }) {
  const list = useRef<HTMLElement>(null);
  // On a narrow screen the row of pages scrolls sideways: the one that is open is brought into it.
  useEffect(() => {
    const open = list.current?.querySelector<HTMLElement>("[aria-current]");
    if (list.current !== null && open != null) list.current.scrollLeft = open.offsetLeft - (list.current.clientWidth - open.offsetWidth) / 2;
  }, [path]);
  return (
    <header class="header">
      <a class="brand" href={homePath(person.role)}><BrandMark /><span>Enamel</span></a>
      <nav aria-label="Main" ref={list}>
        <ul>
          {navigation(person.role).map((item) => (
            <li key={item.path}>
              <a href={item.path} {...(path === item.path || path.startsWith(`${item.path}/`) ? { "aria-current": "page" as const } : {})}>{item.title}</a>
            </li>
          ))}
        </ul>
      </nav>
      <div class="account">
        <a class="account-name" href="/account" {...(path === "/account" ? { "aria-current": "page" as const } : {})}>{person.display_name}<span class="account-role">{person.role}</span></a>
        <button type="button" class="button small" onClick={() => void signOut()}>Sign out</button>
      </div>
    </header>
  );
}

function screen(route: Route, person: Person): ComponentChildren {
  const teacher = person.role !== "student";
  const narrow = (query: Readonly<Record<string, string>>) => navigate(location.value.pathname + queryText(query), "replace");
  switch (route.name) {
    case "home": return null;
    case "exercises": return teacher ? <StaffExercisesPage client={client} query={route.query} onQuery={narrow} onOpen={navigate} /> : <ExercisesPage client={client} />;
    case "exercise": return <OneExercise client={client} id={route.id} personId={person.id} teacher={teacher} onOpen={navigate} />;
    case "attempts": return <AttemptsPage client={client} mine={!teacher} query={route.query} onQuery={narrow} />;
    case "attempt": return <OneAttempt client={client} person={person} id={route.id} onOpen={navigate} />;
    case "account": return <AccountPage client={client} person={person} />;
    case "assignments": if (!teacher) return <MyWorkPage client={client} />; break;
    default: break;
  }
  return teacher ? <Staff route={route} person={person} onQuery={narrow} /> : <NotFound home={homePath(person.role)} />;
}

function OneAttempt(props: ComponentProps<typeof AttemptPage>) {
  const loaded = usePart(() => import("../features/attempt/attempt_page"));
  return loaded === "loading" || loaded === "failed" ? <PartState state={loaded} /> : <loaded.AttemptPage {...props} />;
}

function OneExercise(props: ComponentProps<typeof ExercisePage>) {
  const loaded = usePart(() => import("../features/exercises/exercise_page"));
  return loaded === "loading" || loaded === "failed" ? <PartState state={loaded} /> : <loaded.ExercisePage {...props} />;
}

// What only teachers and admins see.
function Staff({ route, person, onQuery }: { readonly route: Route; readonly person: Person; readonly onQuery: (query: Readonly<Record<string, string>>) => void }) {
  const loaded = usePart(() => import("./staff"));
  if (loaded === "loading" || loaded === "failed") return <PartState state={loaded} />;
  return loaded.staffScreen({ client, route, person, onQuery, onOpen: navigate }) ?? <NotFound home={homePath(person.role)} />;
}

function NotFound({ home }: { readonly home: string }) {
  return (
    <>
      <PageTitle document="Not found">There is no such page for you</PageTitle>
      <p>Check the address, or go to <a href={home}>the start</a>.</p>
    </>
  );
}
