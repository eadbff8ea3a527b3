import { Title } from "../app/title";

export function RenderPage() {
  return <Title text="RenderPage" />;
}
