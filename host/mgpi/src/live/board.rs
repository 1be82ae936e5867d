//! The page of one board, as it is served.

use std::time::Duration;

use report::page::PLOTS;

use super::feed::{Feed, Order, Seen};
use super::page;
use super::server::{HTML, NO_ORDER, SCRIPT, Site};

impl Site for Feed {
    fn get(&self, path: &str) -> Option<(&'static str, String)> {
        match path {
            "/" => Some((HTML, page::page())),
            "/plot.js" => Some((SCRIPT, PLOTS.to_owned())),
            "/live.js" => Some((SCRIPT, page::SCRIPT.to_owned())),
            _ => None,
        }
    }

    fn order(&self, path: &str) -> Result<(), String> {
        let order = match path {
            "/stop" => Order::Stop,
            "/acknowledge" => Order::Acknowledge,
            _ => return Err(NO_ORDER.to_owned()),
        };
        Feed::order(self, order);
        Ok(())
    }

    fn events(&self) -> impl FnMut(Duration) -> Option<String> {
        let (feed, mut seen) = (self.clone(), Seen::default());
        move |limit| feed.news(&mut seen, limit).map(|news| news.to_string())
    }
}
