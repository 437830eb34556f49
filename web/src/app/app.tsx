import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { Client } from "../api/client";
import type { Person, Session } from "../api/types";
import { unreachable } from "../base/assert";
import { AuditPage, JobsPage, PeoplePage, ProfilesPage, StationsPage } from "../features/admin/admin_pages";
import { AttemptPage } from "../features/attempt/attempt_page";
import { AttemptsPage } from "../features/attempts/attempts_page";
import { ExercisePage } from "../features/exercises/exercise_page";
import { ExercisesPage } from "../features/exercises/exercises_page";
import { SignIn } from "../features/sign_in/sign_in";
import { ErrorNotice, Loading, PageTitle } from "../widgets/basics";
import { BrandMark } from "../widgets/brand";
import { location, navigate } from "./location";
import { homePath, navigation, parseRoute, type Route } from "./routes";

// Who is using the page. The address stays while signed out, so that signing in again leads back.
type SessionState =
  | { readonly state: "unknown" }
  | { readonly state: "unreachable"; readonly message: string }
  | { readonly state: "out"; readonly notice?: string }
  | { readonly state: "in"; readonly person: Person };

const session = signal<SessionState>({ state: "unknown" });
const client = new Client(() => {
  if (session.value.state !== "in") return;
  session.value = { state: "out", notice: "Your session has ended. Sign in again to continue where you were." };
});

export async function restoreSession(): Promise<void> {
  const result = await client.currentSession();
  if (result.ok) session.value = { state: "in", person: result.value.person };
  else if (result.error.code === "unauthenticated") session.value = { state: "out" };
  else session.value = { state: "unreachable", message: result.error.message };
}

function signedIn({ person }: Session): void {
  session.value = { state: "in", person };
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
    case "out": return <SignIn client={client} notice={now.notice} onSignedIn={signedIn} />;
    case "in": return <SignedIn person={now.person} />;
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
    </>
  );
}

function Header({ person, path }: { readonly person: Person; readonly path: string }) {
  return (
    <header class="header">
      <a class="brand" href={homePath(person.role)}><BrandMark /><span>Enamel</span></a>
      <nav aria-label="Main">
        <ul>
          {navigation(person.role).map((item) => (
            <li key={item.path}>
              <a href={item.path} {...(path === item.path || path.startsWith(`${item.path}/`) ? { "aria-current": "page" as const } : {})}>{item.title}</a>
            </li>
          ))}
        </ul>
      </nav>
      <div class="account">
        <span class="account-name">{person.display_name}<span class="account-role">{person.role}</span></span>
        <button type="button" class="button small" onClick={() => void signOut()}>Sign out</button>
      </div>
    </header>
  );
}

function screen(route: Route, person: Person): ComponentChildren {
  switch (route.name) {
    case "home": return null;
    case "exercises": return <ExercisesPage client={client} />;
    case "exercise": return <ExercisePage client={client} id={route.id} personId={person.id} />;
    case "attempts":
      return <AttemptsPage client={client} mine={person.role === "student"} cohort={route.cohort}
                           onCohort={(id) => navigate(`/attempts?cohort=${encodeURIComponent(id)}`, "replace")} />;
    case "attempt": return <AttemptPage client={client} person={person} id={route.id} />;
    case "people": return <PeoplePage client={client} />;
    case "stations": return <StationsPage client={client} />;
    case "profiles": return <ProfilesPage client={client} />;
    case "jobs": return <JobsPage client={client} />;
    case "audit": return <AuditPage client={client} />;
    case "unknown":
      return (
        <>
          <PageTitle document="Not found">There is no such page</PageTitle>
          <p>Check the address, or go to <a href={homePath(person.role)}>the start</a>.</p>
        </>
      );
    default: return unreachable(route);
  }
}
