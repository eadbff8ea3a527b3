import { Title } from "../app/title";

export function ScenePage() {
  return <Title text="ScenePage" />;
}
