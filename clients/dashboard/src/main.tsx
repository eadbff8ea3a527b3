import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/parts.css";

import { render } from "preact";

import { startEvents } from "./api/events";
import { startVocabulary } from "./api/vocabulary";
import { App } from "./app/app";
import { applyTheme } from "./app/theme";

applyTheme();
await Promise.all([startEvents(), startVocabulary()]);
render(<App />, document.getElementById("app")!);
