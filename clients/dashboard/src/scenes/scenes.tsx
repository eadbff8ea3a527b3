import { Title } from "../app/title";

export function Scenes() {
  return <Title text="Scenes" />;
}
