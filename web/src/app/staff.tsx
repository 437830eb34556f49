import type { ComponentChildren } from "preact";
import type { Client } from "../api/client";
import { AssignmentPage } from "../features/assignments/assignment_page";
import { AssignmentsPage } from "../features/assignments/assignments_page";
import { CohortPage } from "../features/cohorts/cohort_page";
import { CohortsPage } from "../features/cohorts/cohorts_page";
import { GradingPage } from "../features/grading/grading_page";
import { StationsPage } from "../features/stations/stations_page";
import { part } from "../widgets/part";
import { isForAdmins, type ScreenProps } from "./routes";

const Editors = part("editors", () => import("./editors"));
const Live = part("live", () => import("./live"));
const Marking = part("marking", () => import("./marking"));
const More = part("more", () => import("./more"));

// The screens of teachers and admins; undefined where there is none for this person.
export function staffScreen({ client, route, person, onQuery, onOpen }: ScreenProps): ComponentChildren | undefined {
  const admin = person.role === "admin";
  switch (route.name) {
    case "assignments":
      return (
        <AssignmentsPage
          client={client}
          query={route.query}
          onQuery={onQuery}
          onOpen={(id) => onOpen(`/assignments/${id}`)}
        />
      );
    case "assignment":
      return (
        <AssignmentPage
          client={client}
          id={route.id}
          onGone={() => onOpen("/assignments")}
          insight={(assignment) => (
            <More show={({ InsightCard }) => <InsightCard client={client} assignment={assignment} />} />
          )}
          marking={(assignment) => (
            <More show={({ MarkingCard }) => <MarkingCard client={client} assignment={assignment} self={person} />} />
          )}
        />
      );
    case "marking":
      return <Marking show={({ MarkingPage }) => <MarkingPage client={client} id={route.id} />} />;
    case "grading":
      return (
        <GradingPage
          key={`${route.query.get("assignment")} ${route.query.get("cohort")}`}
          client={client}
          query={route.query}
          onQuery={onQuery}
          onOpen={onOpen}
        />
      );
    case "cohorts":
      return <CohortsPage client={client} admin={admin} />;
    case "cohort":
      return <CohortPage client={client} id={route.id} admin={admin} />;
    case "live":
      return <Live show={({ LivePage }) => <LivePage client={client} />} />;
    case "watch":
      return <Live show={({ WatchPage }) => <WatchPage client={client} id={route.id} />} />;
    case "stations":
      return <StationsPage client={client} admin={admin} />;
    case "profiles":
      return <More show={({ ProfilesPage }) => <ProfilesPage client={client} admin={admin} />} />;
    case "profile":
      return <More show={({ ProfilePage }) => <ProfilePage client={client} name={route.id} admin={admin} />} />;
    case "editor":
      return editor(client, route.query, admin, onOpen);
    default:
      return admin && isForAdmins(route) ? (
        <More show={(more) => more.adminScreen({ client, route, person, onQuery, onOpen })} />
      ) : undefined;
  }
}

// Of an exercise, of the rubric of one that is published, or of a device profile.
function editor(
  client: Client,
  query: URLSearchParams,
  admin: boolean,
  onOpen: ScreenProps["onOpen"],
): ComponentChildren | undefined {
  const [exercise, rubric, profile] = ["exercise", "rubric", "profile"].map((name) => query.get(name));
  if (exercise != null)
    return (
      <Editors
        show={({ ExerciseEditorPage }) => <ExerciseEditorPage client={client} id={exercise} onOpen={onOpen} />}
      />
    );
  if (rubric != null)
    return (
      <Editors show={({ RubricEditorPage }) => <RubricEditorPage client={client} id={rubric} onOpen={onOpen} />} />
    );
  return profile != null && admin ? (
    <Editors show={({ ProfileEditorPage }) => <ProfileEditorPage client={client} name={profile} onOpen={onOpen} />} />
  ) : undefined;
}
