// Which room a path leads to. Rooms are fetched when first asked for, so that the first page shows at once.

import { ErrorBoundary, lazy, LocationProvider, Route, Router } from "preact-iso";

import { Now } from "../now/now";
import { NotFound } from "./not_found";
import { Shell } from "./shell";

const Jobs = lazy(() => import("../jobs/jobs").then((room) => room.Jobs));
const JobPage = lazy(() => import("../job/job").then((room) => room.JobPage));
const RenderPage = lazy(() => import("../render/render").then((room) => room.RenderPage));
const Compare = lazy(() => import("../compare/compare").then((room) => room.Compare));
const Studies = lazy(() => import("../studies/studies").then((room) => room.Studies));
const Study = lazy(() => import("../studies/study").then((room) => room.Study));
const NewStudy = lazy(() => import("../studies/new_study").then((room) => room.NewStudy));
const HardCases = lazy(() => import("../studies/hard_cases").then((room) => room.HardCases));
const Sequences = lazy(() => import("../sequences/sequences").then((room) => room.Sequences));
const SequencePage = lazy(() => import("../sequences/sequence").then((room) => room.SequencePage));
const Scenes = lazy(() => import("../scenes/scenes").then((room) => room.Scenes));
const ApiReference = lazy(() => import("../api_reference/reference").then((room) => room.ApiReference));
const ScenePage = lazy(() => import("../scenes/scene").then((room) => room.ScenePage));

export function App() {
  return (
    <LocationProvider>
      <Shell>
        <ErrorBoundary>
          <Router>
            <Route path="/" component={Now} />
            <Route path="/jobs" component={Jobs} />
            <Route path="/jobs/:id" component={JobPage} />
            <Route path="/render" component={RenderPage} />
            <Route path="/compare" component={Compare} />
            <Route path="/studies" component={Studies} />
            <Route path="/studies/new" component={NewStudy} />
            <Route path="/studies/hard-cases" component={HardCases} />
            <Route path="/studies/:id" component={Study} />
            <Route path="/sequences" component={Sequences} />
            <Route path="/sequences/:id" component={SequencePage} />
            <Route path="/scenes" component={Scenes} />
            <Route path="/scenes/:scene" component={ScenePage} />
            <Route path="/api" component={ApiReference} />
            <Route default component={NotFound} />
          </Router>
        </ErrorBoundary>
      </Shell>
    </LocationProvider>
  );
}
