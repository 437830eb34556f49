import type { ComponentChildren } from "preact";
import type { Client } from "../api/client";
import type { Person } from "../api/types";
import { AssignmentPage } from "../features/assignments/assignment_page";
import { AssignmentsPage } from "../features/assignments/assignments_page";
import { CohortPage } from "../features/cohorts/cohort_page";
import { CohortsPage } from "../features/cohorts/cohorts_page";
import { GradingPage } from "../features/grading/grading_page";
import { LivePage } from "../features/live/live_page";
import { WatchPage } from "../features/live/watch_page";
import { AuditPage } from "../features/operations/audit_page";
import { JobsPage } from "../features/operations/jobs_page";
import { PeoplePage } from "../features/people/people_page";
import { PersonPage } from "../features/people/person_page";
import { RosterPage } from "../features/people/roster_page";
import { ProfilePage } from "../features/profiles/profile_page";
import { ProfilesPage } from "../features/profiles/profiles_page";
import { StationsPage } from "../features/stations/stations_page";
import type { Route } from "./routes";

interface Props {
  readonly client: Client;
  readonly route: Route;
  readonly person: Person;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
  readonly onOpen: (path: string) => void;
}

// The screens of teachers and admins; undefined where there is none for this person.
export function staffScreen({ client, route, person, onQuery, onOpen }: Props): ComponentChildren | undefined {
  const admin = person.role === "admin";
  switch (route.name) {
    case "assignments": return <AssignmentsPage client={client} query={route.query} onQuery={onQuery} onOpen={(id) => onOpen(`/assignments/${id}`)} />;
    case "assignment": return <AssignmentPage client={client} id={route.id} onGone={() => onOpen("/assignments")} />;
    case "grading": return <GradingPage key={route.query.toString()} client={client} query={route.query} onOpen={onOpen} />;
    case "cohorts": return <CohortsPage client={client} admin={admin} />;
    case "cohort": return <CohortPage client={client} id={route.id} admin={admin} />;
    case "live": return <LivePage client={client} />;
    case "watch": return <WatchPage client={client} id={route.id} />;
    case "stations": return <StationsPage client={client} admin={admin} />;
    case "profiles": return <ProfilesPage client={client} admin={admin} />;
    case "profile": return <ProfilePage client={client} name={route.id} admin={admin} />;
    default: return admin ? adminScreen(route, client, person, onQuery, onOpen) : undefined;
  }
}

function adminScreen(route: Route, client: Client, person: Person, onQuery: Props["onQuery"], onOpen: Props["onOpen"]): ComponentChildren | undefined {
  switch (route.name) {
    case "people": return <PeoplePage client={client} query={route.query} onQuery={onQuery} />;
    case "person": return <PersonPage client={client} id={route.id} self={route.id === person.id} onGone={() => onOpen("/people")} />;
    case "roster": return <RosterPage client={client} />;
    case "jobs": return <JobsPage client={client} query={route.query} onQuery={onQuery} />;
    case "audit": return <AuditPage client={client} query={route.query} onQuery={onQuery} />;
    default: return undefined;
  }
}
